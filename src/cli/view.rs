//! `rootvox view`: look at a study and change it in a browser.

use super::options::{MachineOptions, StoreOptions, StudyOptions};
use super::progress::Display;
use super::terminal::{dataln, talkln};
use crate::error::Result;
use crate::view::{Opening, Served, Session, serve};
use clap::Args;
use std::sync::{Arc, OnceLock};

/// Look at a study in a browser, move its settings and see the roots follow.
///
/// Brings the study up to date and serves its page on this machine alone, at an address that holds a secret: whoever has it can
/// change the study. Settings of extraction, tracing and hierarchy have sliders; "Keep" writes them into the study file. Roots that are
/// wrong are corrected by click; corrections are written into the study's file of corrections. What is computed is in the store, as after
/// `rootvox run`. Ctrl-C ends it and loses nothing.
///
/// On another machine: ssh -L 8000:127.0.0.1:8000 HOST, there `rootvox view STUDY --port 8000 --no-open`, and open the address that it
/// prints here.
///
/// Example:
///   rootvox view pipelines/quickstart.toml
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct View {
    #[command(flatten)]
    study: StudyOptions,
    /// Port to serve at; a free one when absent.
    #[arg(long, value_name = "PORT", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Open no browser; the address is printed all the same.
    #[arg(long)]
    no_open: bool,
    /// Write nothing into the study file or beside it.
    #[arg(long)]
    read_only: bool,
    #[command(flatten)]
    store: StoreOptions,
    #[command(flatten)]
    machine: MachineOptions,
}

impl View {
    /// Serves the page until Ctrl-C.
    ///
    /// # Errors
    /// Faults of the study, a port that is taken.
    pub fn run(&self) -> Result<()> {
        let served = Served::at(self.port)?;
        let end = super::cancel::flag()?;
        let opening = Opening {
            study: self.study.study.clone(),
            overrides: self.study.set.clone(),
            threads: self.machine.threads(),
            memory_bytes: self.machine.memory_bytes(),
            read_only: self.read_only,
        };
        let display = OnceLock::new();
        let session = Session::open(
            opening,
            self.store.open()?,
            &end,
            |names| drop(display.set(Display::new(names))),
            |event| {
                if let Some(display) = display.get() {
                    display.show(event);
                }
            },
        );
        display.get().inspect(|display| display.finish());
        let session = Arc::new(session?);
        let address = served.address()?;
        dataln!("{address}");
        talkln!("Ctrl-C ends it");
        if !self.no_open
            && let Err(e) = open::that_detached(&address)
        {
            talkln!("note: no browser could be opened ({e}): open the address by hand");
        }
        serve(served, &session, &end)
    }
}
