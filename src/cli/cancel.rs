//! Ctrl-C: the first asks running nodes to stop, the second ends the process at once.

use super::terminal::talkln;
use crate::error::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that Ctrl-C raises.
///
/// # Errors
/// Where the handler cannot be set.
pub fn flag() -> Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = flag.clone();
    ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::SeqCst) {
            #[expect(clippy::exit, reason = "the user insists; finished nodes are on disk already")]
            std::process::exit(130);
        }
        talkln!("stopping: finished nodes are kept; press Ctrl-C again to stop at once");
    })
    .map_err(|e| Error::failed(format!("cannot listen for Ctrl-C: {e}")))?;
    Ok(flag)
}
