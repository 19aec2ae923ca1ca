//! Sockets, read on a thread of their own so that arrivals are stamped at once.

use super::host::tell;
use super::inbox::{Inbox, Item};
use super::lines::{Line, Lines, MAX_LINE};
use super::message::parse;
use crate::error::{Error, Result};
use crate::source::{GazeSource, SourceEvent, SourceInfo};
use crate::stamp::{StampSettings, Stamper};
use crate::time::{HOST_CLOCK, host_now_ns};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::io::{self, Read};
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::os::unix::fs::{FileTypeExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

/// How often the thread looks whether it shall end.
const WAIT: Timespec = Timespec { tv_sec: 0, tv_nsec: 50_000_000 };
/// The most programs connected at once.
const MAX_CLIENTS: usize = 16;
/// Another UDP sender is heard when the one before has been silent for so long.
const TAKEOVER_NS: i64 = 2_000_000_000;

/// How a bridge is opened.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BridgeSettings {
    /// How its samples are judged.
    pub stamp: StampSettings,
}

/// Gaze from another program, by the line protocol ([`crate::bridge`]).
///
/// Events: [`SourceEvent::Reconnected`] when a sender is heard for the first time or again,
/// [`SourceEvent::Disconnected`] when it goes, [`SourceEvent::Rejected`] for what is no sample.
#[derive(Debug)]
pub struct Bridge {
    info: SourceInfo,
    inbox: Arc<Inbox>,
    stamper: Stamper,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    /// To be removed at the end.
    socket: Option<PathBuf>,
    port: Option<u16>,
}

impl Bridge {
    /// Listens on a Unix socket that only this user may write to. A socket that nobody listens on any
    /// more is replaced.
    ///
    /// # Errors
    /// [`Error::File`]: something else is there, or another program listens on it; [`Error::Io`].
    pub fn unix(path: &Path, settings: BridgeSettings) -> Result<Self> {
        clear(path)?;
        let io = |error| Error::io(path, error);
        let listener = UnixListener::bind(path).map_err(io)?;
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o600)).map_err(io)?;
        listener.set_nonblocking(true).map_err(io)?;
        let name = format!("bridge on {}", path.display());
        let serve = move |hearing, stop: &AtomicBool| serve_unix(&listener, hearing, stop);
        let mut bridge = Self::start(name, settings, serve).map_err(io)?;
        bridge.socket = Some(path.to_owned());
        Ok(bridge)
    }

    /// Listens on a UDP port of the loopback address, which any program of this machine may send to; 0
    /// takes a free one.
    ///
    /// # Errors
    /// [`Error::Device`]: the port is taken or not allowed.
    pub fn udp(port: u16, settings: BridgeSettings) -> Result<Self> {
        let device = |error| Error::device(format!("UDP port {port} of 127.0.0.1"), error);
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, port)).map_err(device)?;
        socket.set_nonblocking(true).map_err(device)?;
        let port = socket.local_addr().map_err(device)?.port();
        let serve = move |hearing, stop: &AtomicBool| serve_udp(&socket, hearing, stop);
        let name = format!("bridge on UDP port {port}");
        let mut bridge = Self::start(name, settings, serve).map_err(device)?;
        bridge.port = Some(port);
        Ok(bridge)
    }

    /// The UDP port, if it is one.
    #[must_use]
    pub fn port(&self) -> Option<u16> {
        self.port
    }

    fn start<Sender: Copy + PartialEq + Send + 'static>(
        name: String,
        settings: BridgeSettings,
        serve: impl FnOnce(Hearing<Sender>, &AtomicBool) + Send + 'static,
    ) -> io::Result<Self> {
        let inbox = Arc::new(Inbox::default());
        let stop = Arc::new(AtomicBool::new(false));
        let hearing = Hearing { inbox: Arc::clone(&inbox), heard: None };
        let stopped = Arc::clone(&stop);
        let thread =
            std::thread::Builder::new().name("gaze-bridge".into()).spawn(move || serve(hearing, &stopped))?;
        let info = SourceInfo {
            name,
            device_clock: "sender (ns)".into(),
            host_clock: HOST_CLOCK.into(),
            rate_hz: settings.stamp.rate_hz,
        };
        let stamper = Stamper::new(settings.stamp);
        Ok(Self { info, inbox, stamper, stop, thread: Some(thread), socket: None, port: None })
    }
}

impl GazeSource for Bridge {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn poll(&mut self, now_ns: i64, events: &mut Vec<SourceEvent>) -> Result<()> {
        tell(&self.inbox, &mut self.stamper, now_ns, events);
        Ok(())
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // It had nothing to say but what is in the inbox.
            let _ = thread.join();
        }
        if let Some(path) = &self.socket {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Makes room for a socket at `path`.
fn clear(path: &Path) -> Result<()> {
    let Ok(metadata) = std::fs::symlink_metadata(path) else { return Ok(()) };
    if !metadata.file_type().is_socket() {
        return Err(Error::file(path, "is there already and no socket; choose another name"));
    }
    match UnixStream::connect(path) {
        Err(error) if error.kind() == io::ErrorKind::ConnectionRefused => {
            std::fs::remove_file(path).map_err(|error| Error::io(path, error))
        }
        Ok(_) => Err(Error::file(path, "another program listens on it; choose another name or end that one")),
        Err(error) => Err(Error::io(path, error)),
    }
}

/// Which sender is heard.
struct Hearing<Sender> {
    inbox: Arc<Inbox>,
    heard: Option<(Sender, i64)>,
}

impl<Sender: Copy + PartialEq> Hearing<Sender> {
    fn reject(&self, why: impl Into<String>) {
        self.inbox.put(host_now_ns(), Item::Rejected { count: 1, why: why.into() });
    }

    /// One message of a sender. `silence_ns` is how long the one that is heard may be silent.
    fn message(&mut self, sender: Sender, message: &[u8], received_ns: i64, silence_ns: i64) {
        let mut sample = match parse(message) {
            Ok(sample) => sample,
            Err(why) => return self.inbox.put(received_ns, Item::Rejected { count: 1, why }),
        };
        match self.heard {
            Some((heard, _)) if heard == sender => {}
            Some((_, last_ns)) if received_ns.saturating_sub(last_ns) < silence_ns => {
                let why = "another program is heard; end that one first".into();
                return self.inbox.put(received_ns, Item::Rejected { count: 1, why });
            }
            heard => {
                if heard.is_some() {
                    let why = "it was silent, and another program sends".into();
                    self.inbox.put(received_ns, Item::Left { why });
                }
                self.inbox.put(received_ns, Item::Joined);
            }
        }
        self.heard = Some((sender, received_ns));
        sample.received_ns = received_ns;
        self.inbox.put(received_ns, Item::Sample { sample, on_host_clock: false });
    }

    fn left(&mut self, sender: Sender, why: impl Into<String>) {
        if self.heard.is_some_and(|(heard, _)| heard == sender) {
            self.heard = None;
            self.inbox.put(host_now_ns(), Item::Left { why: why.into() });
        }
    }
}

struct Client {
    number: u64,
    stream: UnixStream,
    lines: Lines,
}

fn serve_unix(listener: &UnixListener, mut hearing: Hearing<u64>, stop: &AtomicBool) {
    let mut clients: Vec<Client> = Vec::new();
    let mut number = 0;
    let mut buffer = vec![0; 2 * MAX_LINE];
    while !stop.load(Ordering::Relaxed) {
        let ready: Vec<bool> = {
            let streams = clients.iter().map(|client| PollFd::new(&client.stream, PollFlags::IN));
            let mut waiting: Vec<PollFd<'_>> =
                std::iter::once(PollFd::new(listener, PollFlags::IN)).chain(streams).collect();
            // An interruption is as good as nothing to read.
            let _ = poll(&mut waiting, Some(&WAIT));
            waiting.iter().skip(1).map(|waiting| !waiting.revents().is_empty()).collect()
        };
        let mut ready = ready.into_iter();
        clients.retain_mut(|client| {
            !ready.next().unwrap_or(false) || read_client(client, &mut buffer, &mut hearing)
        });
        accept(listener, &mut clients, &mut number, &hearing);
    }
}

/// Takes the programs that wait at the door.
fn accept(listener: &UnixListener, clients: &mut Vec<Client>, number: &mut u64, hearing: &Hearing<u64>) {
    match listener.accept() {
        Ok((stream, _)) if clients.len() < MAX_CLIENTS && stream.set_nonblocking(true).is_ok() => {
            *number += 1;
            clients.push(Client { number: *number, stream, lines: Lines::default() });
        }
        Ok(_) => hearing.reject(format!("more than {MAX_CLIENTS} programs want to connect")),
        Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
        Err(error) => {
            hearing.reject(format!("a program could not connect: {error}"));
            // As when there are too many open files: not again at once.
            std::thread::sleep(std::time::Duration::from_millis(50));
        }
    }
}

/// Reads what a program sent; says whether it is still there.
fn read_client(client: &mut Client, buffer: &mut [u8], hearing: &mut Hearing<u64>) -> bool {
    let read = client.stream.read(buffer);
    let received_ns = host_now_ns();
    let Client { number, lines, .. } = client;
    let mut told = |line: Line<'_>| match line {
        Line::Whole(line) => hearing.message(*number, line, received_ns, i64::MAX),
        Line::TooLong => hearing.reject(format!("a line is longer than {MAX_LINE} bytes")),
    };
    match read {
        Ok(0) => {
            lines.end(&mut told);
            hearing.left(*number, "it closed the socket");
            false
        }
        Ok(length) => {
            lines.feed(&buffer[..length.min(buffer.len())], told);
            true
        }
        Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted) => true,
        Err(error) => {
            hearing.left(*number, error.to_string());
            false
        }
    }
}

fn serve_udp(socket: &UdpSocket, mut hearing: Hearing<SocketAddr>, stop: &AtomicBool) {
    let mut buffer = vec![0; MAX_LINE + 1];
    while !stop.load(Ordering::Relaxed) {
        let _ = poll(&mut [PollFd::new(socket, PollFlags::IN)], Some(&WAIT));
        match socket.recv_from(&mut buffer) {
            Ok((length, _)) if length > MAX_LINE => {
                hearing.reject(format!("a datagram is longer than {MAX_LINE} bytes"));
            }
            Ok((length, sender)) => {
                hearing.message(sender, buffer[..length].trim_ascii(), host_now_ns(), TAKEOVER_NS);
            }
            Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted) => {}
            Err(error) => {
                hearing.reject(error.to_string());
                std::thread::sleep(std::time::Duration::from_millis(50));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_sender_is_heard_once_the_first_has_been_silent() {
        let inbox = Arc::new(Inbox::default());
        let mut hearing = Hearing { inbox: Arc::clone(&inbox), heard: None };
        let mut told = |sender: u32, message: &[u8], received_ns: i64| -> Vec<&'static str> {
            hearing.message(sender, message, received_ns, TAKEOVER_NS);
            let kind = |item: Item| match item {
                Item::Sample { .. } => "sample",
                Item::Rejected { .. } => "rejected",
                Item::Joined => "joined",
                Item::Left { .. } => "left",
            };
            std::iter::from_fn(|| inbox.take(i64::MAX)).map(kind).collect()
        };
        let good = b"{\"point\": [0.5, 0.5]}";
        assert_eq!(told(1, b"rubbish", 0), ["rejected"]);
        assert_eq!(told(1, good, 5), ["joined", "sample"]);
        assert_eq!(told(2, good, 6), ["rejected"]);
        // Rubbish keeps nobody's place.
        assert_eq!(told(1, b"rubbish", 1_000_000_000), ["rejected"]);
        assert_eq!(told(2, good, 4 + TAKEOVER_NS), ["rejected"]);
        assert_eq!(told(2, good, 5 + TAKEOVER_NS), ["left", "joined", "sample"]);
        assert_eq!(told(1, good, 6 + TAKEOVER_NS), ["rejected"]);
    }
}
