//! The command line: reads the flags, runs the verb, prints its result on stdout and problems on stderr.

use clap::Parser;
use lacuna::bench::BenchOptions;
use lacuna::cli::{BenchArgs, Cli, Command, VerifyArgs};
use lacuna::config::Settings;
use lacuna::progress::Progress;
use lacuna::{ExitCode, Interrupt, RunError, RunResult, VerifyOptions};
use std::io::Write;

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

/// Says what went wrong. Who has closed stderr does not want to know; the exit code tells all the same.
fn complain(error: &RunError) {
    let _ = writeln!(std::io::stderr(), "lacuna: {error}");
}

/// Writes to stdout. A reader that has closed the pipe wants no more: that is no error.
fn say(text: &str) -> Result<(), RunError> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            let message = format!("cannot write the result to stdout: {e}; check where it goes");
            Err(error(ExitCode::InputOutput, message))
        }
        _ => Ok(()),
    }
}

/// Runs the verb.
fn perform(cli: &Cli, progress: &Progress) -> Result<ExitCode, RunError> {
    let interrupt = Interrupt::on_signals()
        .map_err(|e| error(ExitCode::Failed, format!("the system refuses signal handlers: {e}")))?;
    let settings = || Settings::resolve(cli).map_err(|e| error(ExitCode::Usage, e.to_string()));
    match &cli.command {
        Command::Info(args) => info(&settings()?, args.json, &interrupt, progress),
        Command::Inspect(args) => {
            let result = lacuna::inspect(&settings()?, args.report.as_deref(), &interrupt, progress)?;
            let place = args.report.as_ref().map(|p| p.join("report.html").display().to_string());
            show(&result, &place.unwrap_or_default(), progress)
        }
        Command::Repair(_) => {
            let settings = settings()?;
            let result = lacuna::repair(&settings, &interrupt, progress)?;
            let out = settings.scene.output.as_ref().filter(|_| !settings.run.dry_run);
            let place = out.map(|p| p.join("lacuna").join("report.html").display().to_string());
            show(&result, &place.unwrap_or_default(), progress)
        }
        Command::Verify(args) => verify(args, &settings()?, &interrupt, progress),
        Command::Bench(args) => bench(args, &interrupt, progress),
    }
}

fn error(exit: ExitCode, message: String) -> RunError {
    RunError { exit, message }
}

fn info(
    settings: &Settings,
    as_json: bool,
    interrupt: &Interrupt,
    progress: &Progress,
) -> Result<ExitCode, RunError> {
    let info = lacuna::info(settings, interrupt, progress)?;
    progress.finish();
    if as_json {
        let json = serde_json::to_string_pretty(&info).map_err(|e| error(ExitCode::Failed, e.to_string()))?;
        say(&format!("{json}\n"))?;
    } else {
        say(&info.to_text())?;
    }
    Ok(ExitCode::Done)
}

fn bench(args: &BenchArgs, interrupt: &Interrupt, progress: &Progress) -> Result<ExitCode, RunError> {
    let options = BenchOptions {
        config: args.config.clone(),
        out: args.out.clone(),
        baseline: args.check.clone(),
        only_make: args.make.clone(),
    };
    let outcome = lacuna::bench::bench(&options, interrupt, progress)?;
    say(&outcome.tables)?;
    outcome.worsened.iter().for_each(|what| complain(&error(ExitCode::Failed, what.clone())));
    Ok(outcome.exit)
}

fn verify(
    args: &VerifyArgs,
    settings: &Settings,
    interrupt: &Interrupt,
    progress: &Progress,
) -> Result<ExitCode, RunError> {
    if let Some(out) = &args.digest {
        say(&format!("{}\n", lacuna::digest(out)?))?;
        return Ok(ExitCode::Done);
    }
    let Some(out) = &settings.scene.output else {
        return Err(error(ExitCode::Usage, "no output folder to verify; give it after the scene".to_owned()));
    };
    let options = VerifyOptions {
        threads: settings.run.threads,
        memory_limit_bytes: settings.run.memory_limit_bytes,
        interrupt: interrupt.clone(),
        ..VerifyOptions::default()
    };
    let verdict = lacuna::verify(&settings.scene.input, out, &options)?;
    progress.finish();
    say(&verdict.to_text())?;
    Ok(if verdict.is_ok() { ExitCode::Done } else { ExitCode::Failed })
}

fn show(result: &RunResult, place: &str, progress: &Progress) -> Result<ExitCode, RunError> {
    progress.finish();
    say(&lacuna::report::table(&result.report, place))?;
    Ok(result.exit)
}
