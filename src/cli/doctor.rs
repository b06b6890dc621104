//! `rootvox doctor`: what is installed, what is missing, how to get it.

use super::options::{StoreOptions, human_bytes, machine_memory};
use super::terminal::dataln;
use crate::error::Result;
use clap::Args;
use std::process::Command;

/// Tell what this machine offers and what is missing, with the way to get it.
#[derive(Args)]
pub struct Doctor {
    #[command(flatten)]
    store: StoreOptions,
}

impl Doctor {
    /// Prints one line per finding.
    ///
    /// # Errors
    /// Never for something missing: a finding is the answer.
    pub fn run(&self) -> Result<()> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        dataln!("rootvox   {}", env!("CARGO_PKG_VERSION"));
        dataln!("cores     {cores}");
        let memory =
            machine_memory().map(|(total, free)| format!("{} ({} free)", human_bytes(total), human_bytes(free)));
        dataln!("memory    {}", memory.unwrap_or_else(|| "unknown".into()));
        dataln!("store     {}", self.store_state());
        dataln!("colmap    {}", colmap_state());
        Ok(())
    }

    fn store_state(&self) -> String {
        let folder = &self.store.cache;
        let mut probe = folder.as_path();
        while !probe.exists() {
            match probe.parent() {
                Some(up) if !up.as_os_str().is_empty() => probe = up,
                _ => {
                    probe = std::path::Path::new(".");
                    break;
                }
            }
        }
        match tempfile::tempfile_in(probe) {
            Ok(_) => format!("ok: `{}` can be written", folder.display()),
            Err(e) => format!(
                "MISSING: `{}` cannot be written ({e}); name another folder with --cache or ROOTVOX_CACHE",
                folder.display()
            ),
        }
    }
}

/// Cameras from photographs need the COLMAP program; everything else is built in.
fn colmap_state() -> String {
    match Command::new("colmap").arg("help").env("QT_QPA_PLATFORM", "offscreen").output() {
        Ok(out) => {
            let text = String::from_utf8_lossy(&out.stdout).into_owned();
            let version = text.lines().find(|l| l.contains("COLMAP")).unwrap_or("found, version unknown").trim();
            format!("ok: {version}")
        }
        Err(_) => "MISSING: needed for cameras.source = \"sfm\" only; install it with `apt install colmap`, \
                   `brew install colmap` or `conda install colmap`"
            .to_owned(),
    }
}
