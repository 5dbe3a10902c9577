//! The command line: reads the flags, runs the verb, prints its result on stdout and problems on stderr.

use clap::Parser;
use lacuna::cli::{Cli, Command};
use lacuna::config::Settings;
use lacuna::progress::Progress;
use lacuna::{ExitCode, Interrupt, RunError, RunResult};

#[global_allocator]
static ALLOCATOR: lacuna_system::CountingAllocator = lacuna_system::CountingAllocator;

fn main() -> std::process::ExitCode {
    // Two arenas at most: glibc's default of eight a core keeps freed memory of every worker apart.
    lacuna_system::limit_arenas(2);
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => error.exit(),
    };
    let progress = Progress::new(cli.output.progress, cli.output.quiet);
    lacuna::logging::start(&cli.output, &progress);
    let exit = match perform(&cli, &progress) {
        Ok(exit) => exit,
        Err(error) => {
            complain(&error);
            error.exit
        }
    };
    exit.into()
}

#[allow(clippy::print_stderr, reason = "the command line prints")]
fn complain(error: &RunError) {
    eprintln!("lacuna: {error}");
}

#[allow(clippy::print_stdout, reason = "the command line prints")]
fn say(text: &str) {
    print!("{text}");
}

/// Runs the verb.
fn perform(cli: &Cli, progress: &Progress) -> Result<ExitCode, RunError> {
    let settings =
        Settings::resolve(cli).map_err(|e| RunError { exit: ExitCode::Usage, message: e.to_string() })?;
    let interrupt = Interrupt::on_signals()
        .map_err(|e| RunError { exit: ExitCode::Failed, message: format!("no signal handlers: {e}") })?;
    match &cli.command {
        Command::Info(args) => {
            let info = lacuna::info(&settings, &interrupt, progress)?;
            progress.finish();
            if args.json {
                let json = serde_json::to_string_pretty(&info)
                    .map_err(|e| RunError { exit: ExitCode::Failed, message: e.to_string() })?;
                say(&format!("{json}\n"));
            } else {
                say(&info.to_text());
            }
            Ok(ExitCode::Done)
        }
        Command::Inspect(args) => {
            let result = lacuna::inspect(&settings, args.report.as_deref(), &interrupt, progress)?;
            let place = args.report.as_ref().map(|p| p.join("report.html").display().to_string());
            Ok(show(&result, &place.unwrap_or_default(), progress))
        }
        Command::Repair(_) => {
            let result = lacuna::repair(&settings, &interrupt, progress)?;
            let out = settings.scene.output.as_ref().filter(|_| !settings.run.dry_run);
            let place = out.map(|p| p.join("lacuna").join("report.html").display().to_string());
            Ok(show(&result, &place.unwrap_or_default(), progress))
        }
        _ => Err(RunError { exit: ExitCode::Usage, message: "not in this version".to_owned() }),
    }
}

fn show(result: &RunResult, place: &str, progress: &Progress) -> ExitCode {
    progress.finish();
    say(&lacuna::report::table(&result.report, place));
    result.exit
}
