//! The window, driven by scripts on a virtual screen. Screenshots stay in `target/tmp/screenshots`.

#![cfg(all(feature = "view", target_os = "linux"))]
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

#[path = "support/screen.rs"]
mod screen;
mod support;

use std::path::{Path, PathBuf};
use std::time::Duration;

use gnomon::picture::RgbImage;
use screen::Screen;
use support::{Run, can_render, command, files, gnomon};

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

fn read(path: &Path) -> RgbImage {
    gnomon::picture::read(path).unwrap().image
}

/// A window's contents but for its first rows, where the caption tells what a frame took.
fn below_caption(path: &Path) -> RgbImage {
    const ROWS: u32 = 40;
    let whole = read(path);
    RgbImage::from_fn(whole.width(), whole.height() - ROWS, |x, y| whole.get(x, y + ROWS))
}

/// How far two pictures of one size are apart: mean difference of their bytes.
fn mean_difference(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!((a.width(), a.height()), (b.width(), b.height()));
    let sum: f32 = a.texels().iter().zip(b.texels()).map(|(a, b)| (a - b).abs().element_sum()).sum();
    f64::from(sum) / (3.0 * a.texels().len() as f64)
}

/// Whether a good deal of a picture is bright.
fn is_drawn(path: &Path) -> bool {
    let picture = read(path);
    let bright = picture.texels().iter().filter(|texel| texel.max_element() > 0.2).count();
    bright > picture.texels().len() / 10
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
        "size 640 480\nwait idle\nexpect no error\nquit",
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
    let off =
        mean_difference(&read(&folder.path().join("picture.png")), &read(&folder.path().join("again.png")));
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
    assert!(is_drawn(&shot), "nothing is drawn with the new device");
}

#[test]
fn a_minimised_window_rests_and_draws_again_once_restored() {
    let folder = tempfile::tempdir().unwrap();
    let Some(screen) = Screen::open() else { return };
    if !can_render(folder.path()) {
        return;
    }
    std::fs::write(folder.path().join("first.toml"), SCENE).unwrap();
    let [before, after] = ["12-before-minimised", "13-after-minimised"]
        .map(|name| screenshots().join(name).with_extension("png"));
    // The window comes back with a size of one pixel, and draws that.
    let script = [
        "wait idle",
        &format!("screenshot {}", before.display()),
        "minimize\nwait 1.5\nrestore\nwait idle\nkey Ctrl+P\nwait idle\nexpect saved\nkey Escape",
        "size 640 480\nwait idle\nexpect no error",
        &format!("screenshot {}", after.display()),
        "quit",
    ]
    .join("\n");
    screen.view(folder.path(), &["first.toml", "--size", "640x480"], &script).succeeded();

    let hidden = screen.hidden();
    let [hidden] = hidden.as_slice() else { panic!("the window was not minimised once: {hidden:?}") };
    assert!(hidden.time >= Duration::from_millis(1400), "{hidden:?}");
    assert!(hidden.processor < hidden.time / 10, "the window works on while nobody sees it: {hidden:?}");
    assert_eq!(hidden.size, (1, 1));
    let smallest = read(&folder.path().join("picture.png"));
    assert_eq!((smallest.width(), smallest.height()), (1, 1), "drawn at another size than the window's");
    assert!(is_drawn(&before) && is_drawn(&after), "there is no picture");
    let off = mean_difference(&below_caption(&before), &below_caption(&after));
    assert!(off < 1e-4, "the picture is another than before: {off}");
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
