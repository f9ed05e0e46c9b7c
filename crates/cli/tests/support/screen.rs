//! A virtual screen, and a window manager for it.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::errors::ReplyError;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    AtomEnum, ChangeWindowAttributesAux, ClientMessageEvent, ConfigureWindowAux, ConnectionExt, EventMask,
    PropMode, Window,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

use super::support::{Run, command};

/// Longest run of a window: many times what one takes on a busy machine. The steps of a script have limits of their own.
const LONGEST_RUN: Duration = Duration::from_secs(900);

/// A process that does not outlive its owner.
struct Owned(Child);

impl Drop for Owned {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// An X server without a monitor, whose window manager this is.
pub struct Screen {
    server: Option<Owned>,
    display: String,
    manager: Option<JoinHandle<()>>,
    hidden: Arc<Mutex<Vec<Hidden>>>,
}

impl Screen {
    /// `None` after printing why the test is skipped.
    pub fn open() -> Option<Self> {
        // The server ends with the window manager's connection, even where this process is killed.
        let server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x960x24", "-nolisten", "tcp", "-terminate"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let Ok(mut server) = server.map(Owned) else {
            gnomon_testing::skip("no virtual screen (Xvfb)");
            return None;
        };
        let mut number = String::new();
        let read = BufReader::new(server.0.stdout.take().unwrap()).read_line(&mut number);
        if read.is_err() || number.trim().is_empty() {
            gnomon_testing::skip("Xvfb does not start");
            return None;
        }
        let display = format!(":{}", number.trim());
        let hidden = Arc::default();
        let manager = Manager::new(&display, Arc::clone(&hidden)).unwrap();
        let manager = std::thread::spawn(move || manager.run());
        Some(Self { server: Some(server), display, manager: Some(manager), hidden })
    }

    /// Runs `gnomon view` with a script.
    #[track_caller]
    pub fn view(&self, folder: &Path, arguments: &[&str], script: &str) -> Run {
        std::fs::write(folder.join("script.txt"), script).unwrap();
        let arguments = [&["view", "--script", "script.txt"], arguments].concat();
        let mut command = command(folder, &arguments);
        command.env("DISPLAY", &self.display).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        let mut written = [tempfile::tempfile().unwrap(), tempfile::tempfile().unwrap()];
        let [out, err] = written.each_ref().map(|file| file.try_clone().unwrap());
        let mut window = Owned(command.stdout(out).stderr(err).spawn().unwrap());
        let began = Instant::now();
        let status = loop {
            if let Some(status) = window.0.try_wait().unwrap() {
                break status;
            }
            assert!(began.elapsed() < LONGEST_RUN, "the window hangs: {}", text(&mut written[1]));
            std::thread::sleep(Duration::from_millis(20));
        };
        let [out, err] = written.each_mut().map(text);
        Run { status: status.code(), out, err }
    }

    /// The times that windows were minimised for.
    pub fn hidden(&self) -> Vec<Hidden> {
        self.hidden.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // The window manager ends with the server.
        self.server = None;
        if let Some(manager) = self.manager.take() {
            let _ = manager.join();
        }
    }
}

fn text(file: &mut File) -> String {
    let mut bytes = Vec::new();
    file.rewind().unwrap();
    file.read_to_end(&mut bytes).unwrap();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// What a window did while it was minimised.
#[derive(Clone, Debug)]
pub struct Hidden {
    /// How long it was.
    pub time: Duration,
    /// Processor time that its process took.
    pub processor: Duration,
    /// Its size when it came back.
    pub size: (u16, u16),
}

x11rb::atom_manager! {
    Atoms: AtomsCookie {
        WM_STATE,
        WM_CHANGE_STATE,
        _NET_WM_STATE,
        _NET_WM_STATE_HIDDEN,
        _NET_ACTIVE_WINDOW,
        _NET_WM_PID,
    }
}

/// States of ICCCM, 4.1.3.1.
const NORMAL: u32 = 1;
const ICONIC: u32 = 3;

/// Shows windows as they want to be, and minimises and restores them where they ask for it.
struct Manager {
    connection: RustConnection,
    atoms: Atoms,
    /// The minimised window, since when, and the processor time of its process then.
    minimised: Option<(Window, Instant, Duration)>,
    hidden: Arc<Mutex<Vec<Hidden>>>,
}

impl Manager {
    fn new(display: &str, hidden: Arc<Mutex<Vec<Hidden>>>) -> Result<Self, Box<dyn std::error::Error>> {
        let (connection, screen) = x11rb::connect(Some(display))?;
        let root = connection.setup().roots[screen].root;
        let events = EventMask::SUBSTRUCTURE_REDIRECT | EventMask::SUBSTRUCTURE_NOTIFY;
        let wanted = ChangeWindowAttributesAux::new().event_mask(events);
        connection.change_window_attributes(root, &wanted)?.check()?;
        let atoms = Atoms::new(&connection)?.reply()?;
        Ok(Self { connection, atoms, minimised: None, hidden })
    }

    /// Until the server ends. Requests may be of windows that are gone by now, which does not matter.
    fn run(mut self) {
        while let Ok(event) = self.connection.wait_for_event() {
            let answered = match event {
                Event::MapRequest(request) if self.is_minimised(request.window) => {
                    self.restore(request.window)
                }
                Event::MapRequest(request) => self.show(request.window),
                Event::ConfigureRequest(request) => {
                    let wanted = ConfigureWindowAux::from_configure_request(&request);
                    self.connection.configure_window(request.window, &wanted).map(drop).map_err(Into::into)
                }
                Event::ClientMessage(message) => self.message(&message),
                _ => Ok(()),
            };
            if matches!(answered, Err(ReplyError::ConnectionError(_))) || self.connection.flush().is_err() {
                return;
            }
        }
    }

    fn message(&mut self, message: &ClientMessageEvent) -> Result<(), ReplyError> {
        let window = message.window;
        if message.type_ == self.atoms.WM_CHANGE_STATE && message.data.as_data32()[0] == ICONIC {
            return self.minimise(window);
        }
        if message.type_ == self.atoms._NET_ACTIVE_WINDOW && self.is_minimised(window) {
            return self.restore(window);
        }
        Ok(())
    }

    fn is_minimised(&self, window: Window) -> bool {
        self.minimised.is_some_and(|(minimised, ..)| minimised == window)
    }

    fn show(&self, window: Window) -> Result<(), ReplyError> {
        self.set_state(window, NORMAL)?;
        self.connection.map_window(window)?;
        Ok(())
    }

    /// The window shrinks to nearly nothing meanwhile: a zero-sized one is an error of the protocol.
    fn minimise(&mut self, window: Window) -> Result<(), ReplyError> {
        self.set_state(window, ICONIC)?;
        self.connection.unmap_window(window)?;
        self.connection.configure_window(window, &ConfigureWindowAux::new().width(1).height(1))?;
        self.minimised = Some((window, Instant::now(), self.processor_time(window)?));
        Ok(())
    }

    fn restore(&mut self, window: Window) -> Result<(), ReplyError> {
        let Some((_, since, processor)) = self.minimised.take() else { return Ok(()) };
        let geometry = self.connection.get_geometry(window)?.reply()?;
        let hidden = Hidden {
            time: since.elapsed(),
            processor: self.processor_time(window)?.saturating_sub(processor),
            size: (geometry.width, geometry.height),
        };
        self.hidden.lock().unwrap_or_else(PoisonError::into_inner).push(hidden);
        self.show(window)
    }

    fn set_state(&self, window: Window, state: u32) -> Result<(), ReplyError> {
        let atoms = &self.atoms;
        let hidden: &[u32] = if state == ICONIC { &[atoms._NET_WM_STATE_HIDDEN] } else { &[] };
        let connection = &self.connection;
        connection.change_property32(
            PropMode::REPLACE,
            window,
            atoms.WM_STATE,
            atoms.WM_STATE,
            &[state, 0],
        )?;
        connection.change_property32(
            PropMode::REPLACE,
            window,
            atoms._NET_WM_STATE,
            AtomEnum::ATOM,
            hidden,
        )?;
        Ok(())
    }

    /// Processor time that a window's process has taken so far.
    fn processor_time(&self, window: Window) -> Result<Duration, ReplyError> {
        let property = self.atoms._NET_WM_PID;
        let reply =
            self.connection.get_property(false, window, property, AtomEnum::CARDINAL, 0, 1)?.reply()?;
        let process = reply.value32().and_then(|mut values| values.next()).unwrap();
        let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
        // After the name in parentheses, which may hold anything: utime and stime are fields 14 and 15, in ticks of 10 ms.
        let (_, fields) = stat.rsplit_once(')').unwrap();
        let ticks = fields.split_whitespace().skip(11).take(2).map(|field| field.parse::<u64>().unwrap());
        Ok(Duration::from_millis(10 * ticks.sum::<u64>()))
    }
}
