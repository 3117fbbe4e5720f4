//! Arguments in, exit code out.

mod cli;

use clap::Parser;
use std::process::ExitCode;
use stiffmap::interrupt::Interrupt;

fn main() -> ExitCode {
    quiet_device_selection();
    let arguments = cli::Cli::parse();
    tracing_subscriber::fmt()
        .with_writer(|| cli::streams::Log)
        .with_env_filter(tracing_subscriber::EnvFilter::try_from_env("STIFFMAP_LOG").unwrap_or_else(|_| "error".into()))
        .init();
    let interrupt = Interrupt::default();
    let asked = interrupt.clone();
    let handler = ctrlc::set_handler(move || {
        if asked.requested() {
            // Asked twice.
            cli::leave::at_once();
        }
        asked.request();
        cli::leave::soon();
    });
    if let Err(error) = handler {
        cli::streams::say(&format!("warning: Ctrl-C is not caught: {error}"));
    }
    match cli::fault::caught(|| cli::execute(arguments, &interrupt)) {
        Ok(Ok(())) => ExitCode::from(cli::Exit::Done as u8),
        Ok(Err(error)) => {
            let code = cli::exit_code(&error, &interrupt);
            cli::streams::say(&format!("error: {}", cli::describe(&error)));
            ExitCode::from(code as u8)
        }
        Err(fault) => {
            // Unwinding has removed them, but for those of a thread that still runs.
            let _ = stiffmap::export::atomic::remove_temporaries();
            cli::streams::say(&format!("error: {fault}"));
            ExitCode::from(cli::Exit::Failed as u8)
        }
    }
}

/// Mesa's layer that sorts adapters asks a Wayland display first and, where there is none, complains on stderr; this
/// program sorts adapters itself.
#[cfg(target_os = "linux")]
fn quiet_device_selection() {
    let set = |name: &str| std::env::var_os(name).is_some();
    if !set("XDG_RUNTIME_DIR") && !set("MESA_VK_DEVICE_SELECT") {
        // SAFETY: the program has no other thread yet.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

/// Nothing to quieten.
#[cfg(not(target_os = "linux"))]
fn quiet_device_selection() {}
