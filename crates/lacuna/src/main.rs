//! The command line.

use clap::Parser;
use lacuna::cli::{Cli, Command};
use lacuna::config::Settings;
use lacuna::progress::Progress;
use lacuna::{ExitCode, Interrupt, RunError, RunResult};

#[global_allocator]
static ALLOCATOR: lacuna_system::CountingAllocator = lacuna_system::CountingAllocator;

fn main() -> std::process::ExitCode {
    lacuna_system::limit_arenas(2);
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => error.exit(),
    };
    run(&cli).into()
}

#[allow(clippy::print_stdout, clippy::print_stderr, reason = "the command line prints")]
fn run(cli: &Cli) -> ExitCode {
    let settings = match Settings::resolve(cli) {
        Ok(settings) => settings,
        Err(error) => {
            eprintln!("lacuna: {error}");
            return ExitCode::Usage;
        }
    };
    match perform(cli, &settings) {
        Ok(result) => {
            println!("{}", serde_json::to_string_pretty(&result.report.summary).unwrap_or_default());
            for h in &result.report.holes {
                if h.outcome != lacuna::report::Outcome::Filled {
                    println!("{} {:?} {:?} {:.1} m2: {:?}", h.id, h.class, h.shape, h.area_m2, h.reason);
                }
            }
            for s in &result.report.stages {
                println!("{} {:.2} s cpu {:.2} rss {}", s.name, s.seconds, s.cpu_seconds, s.peak_rss_bytes >> 20);
            }
            println!("{:?} {:?}", result.report.not_holes, result.report.scene);
            result.exit
        }
        Err(error) => {
            eprintln!("lacuna: {error}");
            error.exit
        }
    }
}

fn perform(cli: &Cli, settings: &Settings) -> Result<RunResult, RunError> {
    let interrupt = Interrupt::default();
    let progress = Progress::silent();
    match &cli.command {
        Command::Repair(_) => lacuna::repair(settings, &interrupt, &progress),
        _ => lacuna::inspect(settings, &interrupt, &progress),
    }
}
