//! `mlt`: stratified Metropolis light transport on the command line.

fn main() -> std::process::ExitCode {
    mlt_cli::main()
}
