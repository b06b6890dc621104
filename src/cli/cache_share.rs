//! `rootvox cache push` and `pull`: nodes of a study to and from stores that others share.

use super::options::human_bytes;
use super::reach::{Reach, reach};
use super::terminal::{dataln, talkln};
use crate::error::{Error, Result};
use crate::store::{Destination, Pushed, Store};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

fn bar(count: usize) -> ProgressBar {
    let bar = ProgressBar::new(count as u64);
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} nodes  {msg}  {elapsed}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

fn check(cancel: &AtomicBool) -> Result<()> {
    if cancel.load(Ordering::Relaxed) { Err(Error::interrupted()) } else { Ok(()) }
}

/// Pushes what `store` holds of the study, or lock, at `study`.
///
/// # Errors
/// Faults of the study, and of the destination.
pub fn push(store: &Store, study: &Path, to: &str) -> Result<()> {
    let cancel = super::cancel::flag()?;
    let Reach { nodes, pending, .. } = reach(store, study)?;
    let destination = Destination::open(to)?;
    let bar = bar(nodes.len());
    let (mut sent, mut there, mut bytes) = (0, 0, 0);
    for (stage, key) in nodes {
        check(&cancel)?;
        match destination.push(store, &stage, key)? {
            Some(Pushed::Sent(n)) => (sent, bytes) = (sent + 1, bytes + n),
            Some(Pushed::There) => there += 1,
            None => {}
        }
        bar.set_message(human_bytes(bytes));
        bar.inc(1);
    }
    bar.finish_and_clear();
    dataln!("{sent} nodes sent, {}; {there} were there", human_bytes(bytes));
    if pending > 0 {
        talkln!("note: {pending} nodes of the study are not computed yet");
    }
    Ok(())
}

/// Fetches what `from` has of the study, or lock, at `study` into the store in the folder `cache`.
///
/// # Errors
/// Faults of the study, and of the store.
pub fn pull(cache: &Path, study: &Path, from: &str) -> Result<()> {
    let cancel = super::cancel::flag()?;
    let own = Store::open(cache)?;
    let store = own.clone().over(from)?;
    let Reach { nodes, pending, .. } = reach(&store, study)?;
    let bar = bar(nodes.len());
    let (mut fetched, mut here, mut bytes) = (0, 0, 0);
    for (stage, key) in nodes {
        check(&cancel)?;
        let Some(manifest) = store.lookup(&stage, key)? else { continue };
        if !store.is_far(&manifest) {
            here += usize::from(!manifest.is_virtual);
        } else if let Some(manifest) = store.lookup_values(&stage, key)? {
            (fetched, bytes) = (fetched + 1, bytes + manifest.bytes());
        }
        bar.set_message(human_bytes(bytes));
        bar.inc(1);
    }
    bar.finish_and_clear();
    super::watch::complain(&store);
    dataln!("{fetched} nodes fetched and verified, {}; {here} were here", human_bytes(bytes));
    if pending > 0 {
        talkln!("note: {pending} nodes of the study are in neither store");
    }
    Ok(())
}
