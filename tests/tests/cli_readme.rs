//! Every command that the README shows runs, made small. (`macula demo` is run by `tools/demo`.)

use macula_tests::cli;
use macula_tests::data::workspace;
use std::io::Write;
use std::process::Stdio;

/// The command lines of the README's section "Commands", without their comments.
fn commands() -> Vec<String> {
    let text = std::fs::read_to_string(workspace().join("README.md")).expect("the README");
    let section = text.split("## Commands").nth(1).expect("a section on commands");
    let block = section.split("```").nth(1).expect("a block of commands");
    let uncommented = block.lines().map(|line| line.split('#').next().unwrap_or(line).trim());
    uncommented.filter(|line| line.contains("macula ")).map(str::to_owned).collect()
}

/// The same command on a scene and a display that take a second.
fn made_small(command: &str) -> String {
    let small = command
        .replace("--triangles 250000 --lights 256", "--triangles 10000 --lights 4")
        .replace("--size 1920x1080", "--size 96x54");
    let few = match small.as_str() {
        "macula bench kfr" => " --sizes 64x36 --runs 1 --triangles 10000 --hall-lights 2 --lights 1,2",
        "macula bench vafr" => " --sizes 64x36 --rounds 1 --triangles 10000 --hall-lights 2",
        "macula bench flicker" => " --size 64x36 --frames 3 --triangles 10000 --lights 2",
        // A test of its own runs more of it.
        "macula hardcases --subset" => " --family acuity",
        command if command.starts_with("macula rates") => " --size 96x54 --step-deg 2",
        _ => "",
    };
    small + few
}

#[test]
fn every_command_of_the_readme_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let all = commands();
    assert!(all.len() >= 9, "{all:?}");
    for command in all.iter().filter(|command| !command.ends_with("macula demo")) {
        let small = made_small(command);
        let (input, arguments) = match small.split_once("| macula ") {
            Some((echo, rest)) => (echo.trim_start_matches("echo ").trim(), rest),
            None => ("", small.trim_start_matches("macula ")),
        };
        let mut child = cli::macula(&arguments.split_whitespace().collect::<Vec<_>>())
            .current_dir(folder.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("macula starts");
        let mut stdin = child.stdin.take().expect("a pipe");
        // A command that reads nothing may have ended already.
        let _ = writeln!(stdin, "{input}");
        drop(stdin);
        let output = child.wait_with_output().expect("macula ends");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{small}: {errors}");
        assert!(!output.stdout.is_empty(), "{small}: says nothing");
    }
    for picture in ["kfr.png", "lp.png", "full.png"] {
        assert!(folder.path().join(picture).exists(), "{picture} is not there");
    }
}
