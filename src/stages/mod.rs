//! One file per stage and one list; the only place where domain and engine meet.
