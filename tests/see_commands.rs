//! `makadam picture`, `animate`, `view` and `export`: what they write, what they say, what they refuse.

use crate::support::makadam;
use crate::support::small_scene::smoke;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn simulate(folder: &Path) {
    let arguments = ["--steps", "300", "--output", "results/small"];
    let output = makadam(folder).arg("run").arg(smoke()).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn call(folder: &Path, arguments: &[&str]) -> Output {
    makadam(folder).args(arguments).output().unwrap()
}

fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = call(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn a_run_is_seen_in_every_way() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    simulate(folder);
    let run = folder.join("results/small");
    // By its folder, and by the name of the folder below results.
    let said = done(folder, &["picture", "results/small", "--size", "200x160"]);
    assert!(said.contains("picture.png") && said.contains("smoke at 0.15 s"), "{said}");
    assert!(run.join("picture.png").is_file());
    let options =
        ["--time", "0.09", "--field", "coordination-number", "--view", "30,20", "--clip", "y=0", "--range", "0,6"];
    let said = done(folder, &[&["picture", "small", "--size", "200x160", "-o", "cut.png"], &options[..]].concat());
    assert!(said.contains("cut.png: smoke at 0.1 s, coloured by coordination-number"), "{said}");
    let said =
        done(folder, &["picture", "small", "--size", "160x120", "--every", "2", "--rate", "5", "-o", "film.gif"]);
    assert!(said.contains("film.gif: 2 frames, 0.4 s"), "{said}");
    assert!(folder.join("film.gif").metadata().unwrap().len() > 1000);
    done(folder, &["picture", "small", "--size", "160x120", "-o", "kinds.png", "--field", "material"]);
    let said = done(folder, &["view", "small", "-o", "page.html"]);
    assert!(said.contains("page.html: 4 frames") && said.contains("file:///"), "{said}");
    let said = done(folder, &["export", "small", "--format", "vtkhdf", "-o", "out"]);
    assert!(said.contains("grains.vtkhdf: 4 frames") && said.contains("walls.vtkhdf: 1 frames"), "{said}");
    done(folder, &["export", "small", "--format", "gsd", "-o", "out"]);
    let mut names: Vec<_> =
        std::fs::read_dir(folder.join("out")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["contacts.vtkhdf", "grains.gsd", "grains.vtkhdf", "walls.vtkhdf"]);
    // What was drawn is no part of the run: a run that begins anew in the folder leaves it alone.
    let again =
        call(folder, &["run", smoke().to_str().unwrap(), "--steps", "2", "--output", "results/small", "--restart"]);
    assert!(again.status.success());
    assert!(run.join("picture.png").is_file());
}

#[test]
fn a_scene_named_like_a_hole_of_the_page_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(smoke()).unwrap();
    for name in ["{{payload}}", "{{title}}", "{{script}}"] {
        let scene = folder.path().join("named.toml");
        std::fs::write(&scene, text.replacen("name = \"smoke\"", &format!("name = \"{name}\""), 1)).unwrap();
        let run = ["run", "named.toml", "--steps", "20", "--restart", "--output", "out", "--quiet"];
        done(folder.path(), &run);
        done(folder.path(), &["view", "out", "-o", "page.html"]);
        let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap();
        assert!(page.contains(&format!("<title>{name}</title>")), "{name}");
        let payload = page.split_once("application/octet-stream\">").unwrap().1.split_once("</script>").unwrap().0;
        assert!(payload.len() > 1000, "{name}: {} bytes", payload.len());
    }
}

#[test]
fn what_cannot_be_shown_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    simulate(folder);
    std::fs::create_dir(folder.join("empty")).unwrap();
    let refused = |arguments: &[&str], code: i32, words: &[&str]| {
        let output = call(folder, arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
        words.iter().for_each(|word| assert!(message.contains(word), "{arguments:?}: {word} not in {message}"));
        assert!(!message.contains("panicked"), "{message}");
    };
    for command in ["picture", "picture", "view"] {
        refused(&[command, "nowhere"], 2, &["no run 'nowhere'", "makadam run"]);
        refused(&[command, "empty"], 2, &["empty holds no frames", "frames.mkd"]);
        refused(&[command, "small", "--field", "sped"], 2, &["no field 'sped'", "speed", "coordination_number"]);
    }
    refused(&["export", "nowhere", "--format", "gsd"], 2, &["no run 'nowhere'"]);
    refused(&["export", "small"], 2, &["--format"]);
    refused(&["picture", "small", "--time", "7"], 2, &["7 s lies outside the run", "from 0 s to 0.15 s"]);
    refused(&["picture", "small", "--size", "3x3"], 2, &["64 to 16384"]);
    refused(&["picture", "small", "--view", "behind"], 2, &["AZIMUTH,ELEVATION"]);
    refused(&["picture", "small", "--clip", "q=1"], 2, &["y=0.02"]);
    refused(&["picture", "small", "--range", "2,1"], 2, &["LOW,HIGH"]);
    refused(&["picture", "small", "-o", "a.jpg"], 2, &["a.jpg", ".png", ".gif"]);
    refused(&["picture", "small", "--every", "2"], 2, &["--every", "FILE.gif"]);
    refused(&["picture", "small", "--time", "0.1", "-o", "a.gif"], 2, &["--time", "FILE.png"]);
    refused(&["picture", "small", "-o", "results/small/run.json/a.png"], 1, &["run.json", "name a folder"]);
    refused(&["view", "small", "-o", "x.txt"], 2, &["x.txt", ".html"]);
    refused(&["picture", "small", "--field", "stress"], 2, &["'stress' is in the frames", "6 numbers", "pressure"]);
    let frames = folder.join("results/small/frames.mkd");
    let mut bytes = std::fs::read(&frames).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&frames, &bytes).unwrap();
    refused(&["picture", "small"], 1, &["frames.mkd", "damaged", "run the scene again", "another --time"]);
    refused(&["view", "small"], 1, &["frames.mkd"]);
    // A run that ended has all its frames.
    std::fs::write(&frames, &bytes[..bytes.len() / 2]).unwrap();
    refused(&["view", "small"], 1, &["frames.mkd", "whole frames, and run.json states 4"]);
    let output = call(folder, &["view", "small"]);
    assert!(!String::from_utf8_lossy(&output.stderr).contains("another"), "a page has no --time");
    assert!(!folder.join("results/small/view.html").exists());
}

#[test]
fn what_is_left_out_or_otherwise_than_asked_for_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    simulate(folder);
    let noted = |arguments: &[&str], words: &str| {
        let output = call(folder, arguments);
        let (said, notes) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(output.status.success() && notes.contains(words), "{arguments:?}: no '{words}' in {notes}");
        said.into_owned()
    };
    noted(&["picture", "small", "--size", "64x64", "-o", "new/folder/a.png"], "too narrow for a colour scale");
    assert!(folder.join("new/folder/a.png").is_file());
    let fast = ["picture", "small", "--size", "64x64", "--rate", "1e9", "-o", "fast.gif"];
    let said = noted(&fast, "cannot show 1000000000 frames a second: it shows 100");
    assert!(said.contains("4 frames, 0.04 s"), "{said}");
    let said = noted(&["view", "small", "--megabytes", "0.001", "-o", "a b/v.html"], "more than --megabytes 0.001");
    assert!(said.contains("/a%20b/v.html") && folder.join("a b/v.html").is_file(), "{said}");
}

/// A browser without a screen, if there is one.
fn browser() -> Option<&'static str> {
    let works = |name: &&&str| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success());
    ["chromium", "chromium-browser", "google-chrome"].iter().find(works).copied()
}

#[test]
fn the_page_draws_in_a_browser_without_a_word_of_complaint() {
    let Some(browser) = browser() else {
        eprintln!("skipped: there is no chromium to open the page with");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    simulate(folder);
    done(folder, &["view", "small", "-o", "page.html"]);
    let address = format!("file://{}#ratio=1&chains&clip=y&measure=4", folder.join("page.html").display());
    let arguments = [
        "--headless=new",
        "--no-sandbox",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        "--enable-logging=stderr",
        "--virtual-time-budget=20000",
        "--window-size=800,600",
        "--dump-dom",
    ];
    let profile = format!("--user-data-dir={}", folder.join("profile").display());
    let output = Command::new(browser).args(arguments).arg(profile).arg(address).output().unwrap();
    let (page, log) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let complaints: Vec<&str> = log.lines().filter(|line| line.contains("CONSOLE")).collect();
    assert!(complaints.is_empty(), "{complaints:?}");
    let body = page.split_once("<body").map_or("", |(_, body)| body.split_once('>').map_or("", |(body, _)| body));
    assert!(body.contains("data-ready=\"true\"") && !body.contains("data-trouble"), "{body}\n{log}");
    let measured = body.split_once("data-measured=\"").unwrap().1.split_once('"').unwrap().0.replace("&quot;", "\"");
    let measured: Value = serde_json::from_str(&measured).unwrap();
    assert_eq!(measured["error"], 0, "WebGL complains: {measured}");
    // The browser's clock stands still while a frame is drawn: what a frame takes is measured by hand.
    assert!(measured["milliseconds"].is_number() && measured["size"][0] == 800, "{measured}");
}
