//! The engine: keys, graph, schedule, events; knows nothing of roots.
