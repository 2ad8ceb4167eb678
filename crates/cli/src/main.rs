//! The program: the command line of the library.

fn main() -> std::process::ExitCode {
    hypertexture_cli::main()
}
