"""A render server for Drake's RenderEngineGltfClient: `python -m gnomon.serve --env grace.hdr`.

It speaks the glTF render client-server protocol of Drake's documentation: POST /render with a scene and a camera, an image back: colour as
8-bit PNG, depth as 32-bit TIFF in metres, labels as the colours that Drake gives them. Nothing is added to the scene: it stands on no ground
but its own. The server listens on this machine only unless told otherwise, opens no file that a client names, and limits sizes, times, and how
many requests it holds at once. A refusal is one line of text, with a status of 4xx for what is the client's fault.
"""

import argparse
import contextlib
import email.message
import email.parser
import hashlib
import math
import socket
import struct
import sys
import threading
import time
import traceback
import zlib
from collections import OrderedDict
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np

from . import Camera, DeviceLost, Environment, Error, Renderer, Scene, png

__all__ = ["Server", "main"]

LARGEST_BODY = 256 << 20
"""Longest request [bytes]."""
LARGEST_BODIES = 512 << 20
"""Of all requests that are held at once [bytes]."""
MOST_FIELDS = 64
"""Fields of a form."""
LARGEST_HEAD = 4096
"""Longest head of a field [bytes]."""
LARGEST_SIDE = 4096
"""Widest and highest image [pixels]."""
SECONDS = 30
"""Longest silence of a client, and how long the head of a request may take."""
SLOWEST = 1 << 20
"""A request that comes slower than this [bytes/s] is given up, after those seconds."""
CONNECTIONS = 64
"""Connections that are held at once; more are told to come again."""
WAITING = 16
"""Requests that are read or drawn at once; more are told to come again."""
DRAINED = 2
"""How long what is left of a refused request is read and dropped [s]: a client that is still sending would not see the answer."""
SCENES = 4
"""Scenes that are kept."""
EMPTY = 32766
"""Drake's label of what shows nothing (RenderLabel::kEmpty)."""

# Drake's world has +z up.
Y_UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], np.float32)


class Refused(Exception):
    """A request that is no good: status and sentence."""

    def __init__(self, status, sentence):
        super().__init__(sentence)
        self.status = status


def form(content_type, body):
    """The fields of a multipart form (RFC 7578), as bytes by their names."""
    header = email.message.Message()
    header["Content-Type"] = content_type
    boundary = header.get_boundary()
    if header.get_content_type() != "multipart/form-data" or not boundary:
        raise Refused(400, "the body is no multipart/form-data")
    delimiter = b"\r\n--" + boundary.encode("latin-1", "replace")
    if not body.startswith(delimiter[2:]):
        raise Refused(400, "the form does not begin with its boundary")
    *parts, end = body[len(delimiter) - 2 :].split(delimiter, MOST_FIELDS + 1)
    if not end.startswith(b"--") or len(parts) > MOST_FIELDS:
        raise Refused(400, f"the form has no end, or more than {MOST_FIELDS} fields")
    fields = {}
    for part in parts:
        head, _, value = part.partition(b"\r\n\r\n")
        name = None
        if len(head) <= LARGEST_HEAD:
            head = email.parser.BytesHeaderParser().parsebytes(head.lstrip(b"\r\n"))
            name = head.get_param("name", header="content-disposition")
        if not isinstance(name, str) or name in fields:
            raise Refused(400, "a field of the form has no name, or that of another")
        fields[name] = value
    return fields


class Request:
    """What a client asks for."""

    def __init__(self, fields):
        self.fields = fields
        self.kind = self.text("image_type")
        if self.kind not in ("color", "depth", "label"):
            raise Refused(400, f"image_type is color, depth or label, not {self.kind!r}")
        self.size = tuple(int(self.number(name, 1, LARGEST_SIDE)) for name in ("width", "height"))
        self.lens = {
            name: self.number(field, least, 1e6)
            for name, field, least in [
                ("fx", "focal_x", 1e-3),
                ("fy", "focal_y", 1e-3),
                ("cx", "center_x", -1e6),
                ("cy", "center_y", -1e6),
            ]
        }
        if self.kind == "depth":
            self.range = [self.number(name, 0, 1e9) for name in ("min_depth", "max_depth")]
        if "scene" not in fields:
            raise Refused(400, "the field scene is missing")
        self.scene = fields["scene"]
        self.digest = hashlib.sha256(self.scene).hexdigest()
        if self.text("scene_sha256").lower() != self.digest:
            raise Refused(400, "the scene is not the one that scene_sha256 was made of")

    def text(self, name):
        if name not in self.fields:
            raise Refused(400, f"the field {name} is missing")
        return self.fields[name].decode("utf-8", "replace").strip()

    def number(self, name, least, most):
        try:
            number = float(self.text(name))
        except ValueError:
            number = math.nan
        if not least <= number <= most:
            raise Refused(400, f"{name} must be a number from {least:g} to {most:g}")
        return number


def upright(scene):
    """Turns a scene from +z up to +y up."""
    parents = scene.parents
    for node in range(len(scene.nodes)):
        if parents[node] is None:
            scene.set_pose(node, Y_UP @ scene.pose(node))
    return scene


def png_of_bytes(colors):
    """Colours (height, width, 3) of 8 bits as a PNG file, unchanged (PNG specification, third edition)."""
    height, width, _ = colors.shape

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + row.tobytes() for row in colors.astype(np.uint8))
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + parts


def tiff32(values):
    """Floats as a TIFF file (TIFF 6.0): one strip behind the directory."""
    height, width = values.shape
    data = values.astype("<f4").tobytes()
    # Width, height, bits, no compression, black is 0, strip, channels, rows of the strip, its bytes, IEEE floats.
    entries = [(256, width), (257, height), (258, 32), (259, 1), (262, 1), (273, 0), (277, 1), (278, height), (279, len(data)), (339, 3)]
    start = 8 + 2 + 12 * len(entries) + 4
    directory = b"".join(struct.pack("<HHII", tag, 4, 1, start if tag == 273 else value) for tag, value in entries)
    return b"II*\0" + struct.pack("<IH", 8, len(entries)) + directory + struct.pack("<I", 0) + data


class Server(ThreadingHTTPServer):
    """Draws what clients send under one environment. ``options`` are those of ``Renderer.render``."""

    daemon_threads = True
    # Connections that wait to be taken or refused.
    request_queue_size = 2 * CONNECTIONS

    def __init__(self, address, environment, adapter=None, up="z", exposure=None, **options):
        self.environment = environment
        # Of depth and labels no light is seen; those that were fitted stay with the other.
        self.renderer, self.geometry = Renderer(adapter), Renderer(adapter)
        self.up = up
        self.exposure = environment.exposure if exposure is None else exposure
        self.options = options
        self.scenes = OrderedDict()
        self.lock = threading.Lock()
        self.places = threading.BoundedSemaphore(WAITING)
        self.connections = threading.BoundedSemaphore(CONNECTIONS)
        self.held = 0
        super().__init__(address, Handler)

    def process_request(self, request, client_address):
        if self.connections.acquire(blocking=False):
            super().process_request(request, client_address)
            return
        with contextlib.suppress(OSError):
            request.settimeout(1)
            request.sendall(b"HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nContent-Length: 0\r\n\r\n")
        self.shutdown_request(request)

    def process_request_thread(self, request, client_address):
        try:
            super().process_request_thread(request, client_address)
        finally:
            self.connections.release()

    def handle_error(self, request, client_address):
        # A client that goes away is no news.
        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)

    @contextlib.contextmanager
    def room(self, length):
        """Holds so many bytes of a request, if there is room beside those of the others."""
        with self.lock:
            has_room = self.held + length <= LARGEST_BODIES
            self.held += length if has_room else 0
        if not has_room:
            raise Refused(503, "too much is sent at once: come again")
        try:
            yield
        finally:
            with self.lock:
                self.held -= length

    def scene(self, request):
        """The scene of a request, read once while it is among the last."""
        with self.lock:
            if request.digest in self.scenes:
                self.scenes.move_to_end(request.digest)
                return self.scenes[request.digest]
        is_text = request.scene[:64].lstrip()[:1] == b"{"
        # A sensor measures what the client has sent.
        scene = Scene.load(request.scene, format="gltf" if is_text else "glb", ground="none")
        if self.up == "z":
            upright(scene)
        with self.lock:
            self.scenes[request.digest] = scene
            while len(self.scenes) > SCENES:
                self.scenes.popitem(last=False)
        return scene

    def draw(self, request):
        """The image of a request, and its type."""
        scene = self.scene(request)
        if not scene.cameras:
            raise Refused(400, "the scene has no camera")
        # The glTF camera has no principal point: only its place counts. Drake counts pixels from their corner.
        placed = scene.camera(scene.cameras[0] or "0")
        lens = {**request.lens, "cx": request.lens["cx"] - 0.5, "cy": request.lens["cy"] - 0.5}
        camera = Camera(world_from_camera=placed.world_from_camera, size=request.size, **lens)
        view = (scene, camera, self.environment, request.size)
        if request.kind == "color":
            return png(self.renderer.render(*view, **self.options), self.exposure), "image/png"
        layer = "depth" if request.kind == "depth" else "material"
        drawn = self.geometry.render(*view, layers=[layer], lights="none", ambient="unshadowed", supersample=1)
        if request.kind == "depth":
            least, most = request.range
            depth = drawn["depth"]
            # As Drake's sensors have it: 0 for what is too near, infinity for what is too far.
            return tiff32(np.where(depth < least, 0, np.where(depth > most, np.inf, depth))), "image/tiff"
        # A label is the red and the green byte of a base colour. Nothing is 0, and the default material is the last.
        empty = [EMPTY & 255, EMPTY >> 8, 0]
        colors = [np.rint(np.multiply(scene.material(n)["base_color"], 255)) for n in range(len(scene.materials))]
        return png_of_bytes(np.array([empty, *colors, empty])[drawn["material"]]), "image/png"


class Handler(BaseHTTPRequestHandler):
    """One connection."""

    timeout = SECONDS
    protocol_version = "HTTP/1.1"

    def do_GET(self):
        self.answer(404, b"POST a form to /render\n", "text/plain")

    def handle_one_request(self):
        # The timeout counts from byte to byte: a head that trickles in would go on for ever.
        self.patience = threading.Timer(self.timeout, self.hang_up)
        self.patience.daemon = True
        self.patience.start()
        try:
            super().handle_one_request()
        finally:
            self.patience.cancel()

    def hang_up(self):
        with contextlib.suppress(OSError):
            self.connection.shutdown(socket.SHUT_RD)

    def do_POST(self):
        self.patience.cancel()
        if self.server.places.acquire(blocking=False):
            try:
                status, body, kind = self.drawn()
            finally:
                self.server.places.release()
        else:
            status, body, kind = 503, b"too many requests at once: come again\n", "text/plain"
        self.answer(status, body, kind)
        if status != 200:
            self.drain()

    def drawn(self):
        """What a request is answered: status, body and its type."""
        try:
            if self.path != "/render":
                raise Refused(404, "POST a form to /render")
            length = self.length()
            with self.server.room(length):
                image, kind = self.server.draw(Request(form(self.headers.get("Content-Type", ""), self.body(length))))
            return 200, image, kind
        except Refused as refused:
            return refused.status, f"{refused}\n".encode(), "text/plain"
        except DeviceLost as error:
            return 503, f"{error}\n".encode(), "text/plain"
        except Error as error:
            return 400, f"{error}\n".encode(), "text/plain"
        except TimeoutError:
            return 408, f"the request did not come within {self.timeout} s and {SLOWEST} bytes a second\n".encode(), "text/plain"
        except ConnectionError:
            raise
        except Exception:
            traceback.print_exc()
            return 500, b"the server has a fault; its standard error says which\n", "text/plain"

    def length(self):
        try:
            length = int(self.headers["Content-Length"])
        except (TypeError, ValueError):
            raise Refused(411, "the request does not say how long it is (Content-Length)") from None
        if not 0 <= length <= LARGEST_BODY:
            raise Refused(413, f"a request has at most {LARGEST_BODY} bytes")
        return length

    def body(self, length):
        deadline = time.monotonic() + self.timeout + length / SLOWEST
        parts, left = [], length
        while left > 0:
            if time.monotonic() > deadline:
                raise TimeoutError
            part = self.rfile.read1(min(left, 1 << 20))
            if not part:
                raise Refused(400, "the request ended before it was whole")
            parts.append(part)
            left -= len(part)
        return b"".join(parts)

    def drain(self):
        """Drops what is left of a refused request, for a while."""
        with contextlib.suppress(OSError):
            self.wfile.flush()
            self.connection.shutdown(socket.SHUT_WR)
            self.connection.settimeout(DRAINED)
            deadline = time.monotonic() + DRAINED
            while time.monotonic() < deadline and self.rfile.read1(1 << 20):
                pass

    def answer(self, status, body, kind):
        # What is left of a refused request is not taken for the next one.
        self.close_connection = self.close_connection or status != 200
        try:
            self.send_response(status)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            if self.close_connection:
                self.send_header("Connection", "close")
            self.end_headers()
            self.wfile.write(body)
        except OSError:
            self.close_connection = True

    def log_message(self, *arguments):
        """Says nothing."""


def main(arguments=None):
    """Serves until it is interrupted."""
    parser = argparse.ArgumentParser(prog="python -m gnomon.serve", description=__doc__.splitlines()[0])
    parser.add_argument("--env", required=True, help="environment map, or a built-in one")
    parser.add_argument("--env-rotation", type=float, default=0, help="its turn about the vertical [degrees]")
    parser.add_argument("--host", default="127.0.0.1", help="address to listen at; 0.0.0.0 lets other machines in")
    parser.add_argument("--port", type=int, default=8000)
    parser.add_argument("--adapter", help="part of the name of the graphics adapter")
    parser.add_argument("--up", choices=["y", "z"], default="z", help="the axis of the scenes that points up")
    given = parser.parse_args(arguments)
    try:
        environment = Environment.load(given.env, rotation=given.env_rotation)
        server = Server((given.host, given.port), environment, given.adapter, given.up)
    except (Error, OSError, OverflowError) as error:
        parser.exit(2, f"{parser.prog}: error: {error}\n")
    with server:
        print(f"draws at http://{given.host}:{server.server_port}/render by {server.renderer.adapter['name']}", flush=True)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            pass


if __name__ == "__main__":
    main()
