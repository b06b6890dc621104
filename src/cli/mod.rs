//! The command line: one file per subcommand.
//!
//! stdout carries data, stderr everything else. Exit codes: 0 done, 1 failed, 2 bad usage or study
//! file, 130 interrupted.

mod belt;
mod cache;
mod cache_share;
mod cancel;
mod check;
mod cluster;
mod cluster_status;
mod compare;
pub mod complaint;
mod computed;
mod corrections;
mod doctor;
mod evaluate;
mod explain;
mod export;
mod export_cameras;
mod export_figure;
mod init;
mod options;
mod pack;
mod progress;
mod reach;
mod rerun;
mod run;
mod score_table;
mod shell;
mod simulate;
mod slurm_script;
mod status;
mod tally;
mod terminal;
mod trace;
mod trial;
mod verify;
mod view;
mod watch;
mod why;
mod work;

use crate::error::Result;
use clap::{CommandFactory, Parser, Subcommand};

/// 3D root systems from photographs of a plant in a water-filled transparent cylinder.
///
/// A study is a TOML file that names photographs, cameras and tank; see pipelines/ for examples.
/// Start with:  rootvox run pipelines/quickstart.toml  or, with photographs:  rootvox init FOLDER
#[derive(Parser)]
#[command(name = "rootvox", version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Init(init::Init),
    Run(run::Run),
    View(view::View),
    Rerun(rerun::Rerun),
    Pack(pack::Pack),
    Work(work::Work),
    Cluster(cluster::Cluster),
    Status(status::Status),
    Why(why::Why),
    Check(check::Check),
    Simulate(simulate::Simulate),
    Evaluate(evaluate::Evaluate),
    Compare(compare::Compare),
    Belt(belt::Belt),
    Corrections(corrections::Corrections),
    Export(export::Export),
    Cache(cache::Cache),
    Doctor(doctor::Doctor),
    Completions(shell::Completions),
    Man(shell::Man),
}

/// Parses the arguments of this process and does what they say.
///
/// # Errors
/// Whatever the subcommand met; the error's kind decides the exit code.
pub fn run() -> Result<()> {
    match Arguments::parse().command {
        Command::Init(c) => c.run(),
        Command::Run(c) => c.run(),
        Command::View(c) => c.run(),
        Command::Rerun(c) => c.run(),
        Command::Pack(c) => c.run(),
        Command::Work(c) => c.run(),
        Command::Cluster(c) => c.run(),
        Command::Status(c) => c.run(),
        Command::Why(c) => c.run(),
        Command::Check(c) => c.run(),
        Command::Simulate(c) => c.run(),
        Command::Evaluate(c) => c.run(),
        Command::Compare(c) => c.run(),
        Command::Belt(c) => c.run(),
        Command::Corrections(c) => c.run(),
        Command::Export(c) => c.run(),
        Command::Cache(c) => c.run(),
        Command::Doctor(c) => c.run(),
        Command::Completions(c) => {
            c.run(Arguments::command());
            Ok(())
        }
        Command::Man(c) => c.run(Arguments::command()),
    }
}
