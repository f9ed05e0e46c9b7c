//! The window, driven by scripts on a virtual screen. Screenshots stay in `target/tmp/screenshots`.

#![cfg(all(feature = "view", target_os = "linux"))]
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod support;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use support::{Run, can_render, command, files, gnomon};

/// An X server without a monitor.
struct Screen {
    server: Child,
    display: String,
}

impl Screen {
    /// `None` after printing why the test is skipped.
    fn open() -> Option<Self> {
        let server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x960x24", "-nolisten", "tcp"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let Ok(mut server) = server else {
            gnomon_testing::skip("no virtual screen (Xvfb)");
            return None;
        };
        let mut number = String::new();
        let read = BufReader::new(server.stdout.take().unwrap()).read_line(&mut number);
        if read.is_err() || number.trim().is_empty() {
            gnomon_testing::skip("Xvfb does not start");
            return None;
        }
        Some(Self { server, display: format!(":{}", number.trim()) })
    }

    /// Runs `gnomon view` with a script.
    fn view(&self, folder: &Path, arguments: &[&str], script: &str) -> Run {
        std::fs::write(folder.join("script.txt"), script).unwrap();
        let arguments = [&["view", "--script", "script.txt"], arguments].concat();
        let mut command = command(folder, &arguments);
        command.env("DISPLAY", &self.display).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        Run::of(&command.output().unwrap())
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

fn screenshots() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("screenshots");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// A model that can be dropped: a pyramid without normals.
const MODEL: &str = "v -1 0 -1\nv 1 0 -1\nv 0 0 1\nv 0 1.5 0\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n";

/// A scene that a software adapter draws quickly.
const SCENE: &str = "[[model]]\nbuiltin = \"three-boxes\"\nground = true\n\n[environment]\nbuiltin = \"room\"\n\n\
    [fit]\nlight_count = 12\n\n[render]\nsupersample = 1\n";

/// How far two pictures of one size are apart: mean difference of their bytes.
fn mean_difference(a: &Path, b: &Path) -> f64 {
    let [a, b] = [a, b].map(|path| gnomon::image::read(path).unwrap().image);
    assert_eq!((a.width(), a.height()), (b.width(), b.height()));
    let sum: f32 = a.texels().iter().zip(b.texels()).map(|(a, b)| (a - b).abs().element_sum()).sum();
    f64::from(sum) / (3.0 * a.texels().len() as f64)
}

#[test]
fn a_session_from_opening_to_reopening() {
    let folder = tempfile::tempdir().unwrap();
    let Some(screen) = Screen::open() else { return };
    if !can_render(folder.path()) {
        return;
    }
    std::fs::write(folder.path().join("model.obj"), MODEL).unwrap();
    std::fs::write(folder.path().join("broken.glb"), "glTF, but not really").unwrap();
    std::fs::write(folder.path().join("empty.obj"), "v 0 0 0\n").unwrap();
    let shots = screenshots();
    let shot = |name: &str| format!("screenshot {}", shots.join(name).display());
    let techniques = ["pcss", "moments", "pcf", "hard", "hard-linear", "none", "convolution"]
        .map(|name| {
            format!(
                "choose shadows {name}\nwait idle\n{}\nexpect no error",
                shot(&format!("shadows-{name}.png"))
            )
        })
        .join("\n");
    let script = [
        "wait idle",
        &shot("1-opened.png"),
        "drag left 0.6 0.5 0.75 0.4\ndrag right 0.6 0.5 0.58 0.52\nscroll 0.6 0.5 1\nkey ArrowLeft\nwait idle",
        &shot("2-orbited.png"),
        "expect no error",
        &techniques,
        "key Questionmark\nwait 0.5",
        &shot("3-help.png"),
        "key Escape\ndrop broken.glb\nwait idle\nexpect broken.glb",
        &shot("4-broken-file.png"),
        "key Escape\ndrop empty.obj\nwait idle\nwait 0.3",
        &shot("5-no-triangles.png"),
        "key Escape\ndrop model.obj\nwait idle\nexpect no error\nkey R\nwait samples 1\nwait 0.3",
        &shot("6-reference.png"),
        "key R\nwait samples 2\nwait 0.3",
        &shot("7-difference.png"),
        "key R\nkey D\nwait idle",
        &shot("8-normals.png"),
        "key Shift+D\nwait idle",
        "key Ctrl+P\nwait idle\nexpect saved\nkey Ctrl+S\nwait 0.3\nexpect scene.toml\nexpect no error",
        "size 300 220\nwait idle",
        &shot("9-small.png"),
        "size 1 1\nwait 0.3\nminimize\nwait 0.3\nrestore\nsize 640 480\nwait idle\nexpect no error\nquit",
    ]
    .join("\n");
    std::fs::write(folder.path().join("first.toml"), SCENE).unwrap();
    screen.view(folder.path(), &["first.toml", "--size", "640x480"], &script).succeeded();
    let there = files(folder.path());
    assert!(
        there.contains(&"picture.png".to_owned()) && there.contains(&"scene.toml".to_owned()),
        "{there:?}"
    );

    // A saved scene renders the same.
    gnomon(folder.path(), &["render", "scene.toml", "-o", "again.png"]).succeeded();
    let off = mean_difference(&folder.path().join("picture.png"), &folder.path().join("again.png"));
    assert!(off < 1e-3, "the saved scene renders another picture: {off}");
    // And opens again.
    let script = format!("wait idle\n{}\nexpect no error\nquit", shot("10-reopened.png"));
    screen.view(folder.path(), &["scene.toml", "--size", "640x480"], &script).succeeded();
}

#[test]
fn a_lost_device_is_opened_anew_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let Some(screen) = Screen::open() else { return };
    if !can_render(folder.path()) {
        return;
    }
    let shot = screenshots().join("11-device-lost.png");
    let script = format!(
        "wait idle\nlose device\nwait idle\nexpect device was lost\nscreenshot {}\nquit",
        shot.display()
    );
    screen.view(folder.path(), &["--size", "320x240"], &script).succeeded();
    let picture = gnomon::image::read(&shot).unwrap().image;
    let bright = picture.texels().iter().filter(|texel| texel.max_element() > 0.2).count();
    assert!(bright > picture.texels().len() / 10, "nothing is drawn with the new device");
}

#[test]
fn what_cannot_be_opened_or_done_is_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let without_screen = |arguments: &[&str]| {
        let mut command = command(folder.path(), arguments);
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        Run::of(&command.output().unwrap())
    };
    without_screen(&["view"]).failed("cannot open a window");
    std::fs::write(folder.path().join("script.txt"), "wait idle\ndance").unwrap();
    without_screen(&["view", "--script", "script.txt"]).failed("line 2: 'dance' is no action");
    without_screen(&["view", "--script", "absent.txt"]).failed("absent.txt");
    without_screen(&["view", "--target-fps", "0"]).failed("above 0");
    without_screen(&["view", "--size", "1x1"]).failed("1280x800");
    let Some(screen) = Screen::open() else { return };
    if !can_render(folder.path()) {
        return;
    }
    screen
        .view(
            folder.path(),
            &["absent.glb", "--size", "320x240"],
            "wait idle\nexpect absent.glb\nexpect no error",
        )
        .failed("line 3: there are errors");
}
