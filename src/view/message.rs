//! What the session tells the pages, in the order in which it comes to be.

use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::{Mutex, PoisonError};
use tokio::sync::broadcast;

/// What a message is about; of each a page that comes later is told the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum About {
    /// The values in the study file.
    File,
    /// Settings that are computed now, with the number of their turn.
    Begun,
    /// The root voxels.
    Voxels,
    /// Roots and traits.
    Roots,
    /// The roots on the photographs.
    Views,
    /// How the turn ended: all shown, or why not.
    Ended,
    /// How far the turn is; told once.
    Progress,
}

impl About {
    /// Its name in the stream of events.
    pub fn name(self) -> &'static str {
        match self {
            Self::File => "file",
            Self::Begun => "begun",
            Self::Voxels => "voxels",
            Self::Roots => "roots",
            Self::Views => "views",
            Self::Ended => "ended",
            Self::Progress => "progress",
        }
    }
}

/// One message; its text is JSON on one line.
pub type Message = (About, Arc<str>);

/// Messages that wait for a page that is slow to read; one that is slower connects anew.
const WAITING: usize = 256;

/// Tells messages to all who listen.
pub struct Teller {
    last: Mutex<BTreeMap<About, Arc<str>>>,
    sender: broadcast::Sender<Message>,
}

impl Default for Teller {
    fn default() -> Self {
        Self { last: Mutex::default(), sender: broadcast::channel(WAITING).0 }
    }
}

impl Teller {
    /// Tells a value.
    pub fn tell(&self, about: About, value: &Value) {
        self.tell_text(about, value.to_string());
    }

    /// Tells JSON.
    pub fn tell_text(&self, about: About, text: String) {
        let text: Arc<str> = text.into();
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if about != About::Progress {
            last.insert(about, text.clone());
        }
        // Nobody may be listening.
        let _ = self.sender.send((about, text));
    }

    /// What was told last of everything, and all that is told from now on.
    pub fn listen(&self) -> (Vec<Message>, broadcast::Receiver<Message>) {
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        (last.iter().map(|(about, text)| (*about, text.clone())).collect(), self.sender.subscribe())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn who_comes_later_is_told_the_last_of_everything() {
        let teller = Teller::default();
        teller.tell(About::Begun, &json!(1));
        teller.tell(About::Progress, &json!(0.5));
        teller.tell(About::Begun, &json!(2));
        let (last, mut next) = teller.listen();
        assert_eq!(last, [(About::Begun, "2".into())]);
        teller.tell(About::Ended, &json!(3));
        assert_eq!(next.try_recv().unwrap(), (About::Ended, "3".into()));
    }
}
