# SPDX-License-Identifier: Apache-2.0
"""The Python package `fanlight`: arrays and geometry, render() by the program, a display by a server. FANLIGHT is the
program, PYTHONPATH has the package as it was built."""

import asyncio
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import urllib.request

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from served import SOURCE, served  # noqa: E402

import fanlight  # noqa: E402
from fanlight import arrays, scene, session  # noqa: E402
from fanlight import fanlight_pb2 as pb  # noqa: E402

FAN = dict(motor_radius_mm=30, pixel_height_mm=0.5, pixel_width_mm=0.5, face_column=19.5, face_row=0)
FIELDS = [
    pb.SceneField(name="mode", choices=["surface", "slice"]),
    pb.SceneField(name="light.up_mm", minimum=-2000, maximum=2000),
    pb.SceneField(name="finish.iterations", maximum=9, step=1),
    pb.SceneField(name="cuts.shapes", is_text=True),
]


class Geometry(unittest.TestCase):
    def test_writes_the_keys_of_a_geometry_file(self):
        text = fanlight.Fan(**FAN, frame_kind="convex-lines", line_pitch_deg=0.6, first_angle_deg=-30).toml()
        self.assertIn('frame_kind = "convex-lines"\n', text)
        self.assertIn("line_pitch_deg = 0.6\n", text)
        self.assertIn("first_angle_deg = -30\n", text)
        self.assertNotIn("None", text)
        with self.assertRaisesRegex(ValueError, "expected a finite number"):
            fanlight.Fan(**{**FAN, "face_row": float("nan")}).toml()

    def test_a_grid_has_three_lengths(self):
        for wrong in ((1, 1), (1, 0, 1), (1, 1, float("inf"))):
            with self.assertRaisesRegex(ValueError, "three positive lengths"):
                fanlight.Grid(spacing_mm=wrong)


class Arrays(unittest.TestCase):
    def written(self, array, geometry):
        with tempfile.TemporaryDirectory() as name:
            path = arrays.write(pathlib.Path(name), array, geometry)[0]
            header, pixels = pathlib.Path(path).read_bytes().split(b"ElementDataFile = LOCAL\n")
            return header.decode(), pixels

    def test_pixels_are_those_of_the_array_whatever_its_strides_and_byte_order(self):
        array = np.arange(5 * 4 * 3, dtype=">u2").reshape(3, 4, 5).transpose(2, 1, 0)
        header, pixels = self.written(array, fanlight.Grid(spacing_mm=(3, 2, 1)))
        self.assertIn("DimSize = 3 4 5\n", header)
        self.assertIn("ElementSpacing = 1.0 2.0 3.0\n", header)
        self.assertIn("MET_USHORT", header)
        np.testing.assert_array_equal(np.frombuffer(pixels, "<u2").reshape(array.shape), array)

    def test_frames_have_angles_and_sweeps(self):
        frames = np.zeros((4, 2, 2), np.uint8)
        header, _ = self.written(frames, fanlight.Fan(**FAN, angles_deg=[-1, 0, 1, 2]))
        self.assertIn("Seq_Frame0003_MotorAngleDeg = 2.0\n", header)
        self.assertIn("Seq_Frame0003_VolumeIndex = 0\n", header)
        header, _ = self.written(frames, fanlight.Fan(**FAN, angles_deg=[-1, 1, 1, -1], frames_per_sweep=2))
        self.assertIn("Seq_Frame0003_VolumeIndex = 1\n", header)
        header, _ = self.written(frames, fanlight.Fan(**FAN, angles_deg=[-1, 1, 0, -1]))
        self.assertNotIn("VolumeIndex", header, "the program divides the sweeps where the motor turns back")

    def test_refuses_what_is_no_sweep(self):
        fan = fanlight.Fan(**FAN, angles_deg=[0, 1])
        for array, error in (
            (np.zeros((2, 2), np.uint8), "expected \\(frames, rows, columns\\)"),
            (np.zeros((0, 2, 2), np.uint8), "shape \\(0, 2, 2\\)"),
            (np.zeros((2, 2, 2)), "expected uint8, uint16 or int16"),
            (np.zeros((3, 2, 2), np.uint8), "2 angles_deg for 3 frames"),
        ):
            with self.assertRaisesRegex((TypeError, ValueError), error):
                self.written(array, fan)


class Scenes(unittest.TestCase):
    def test_groups_and_dotted_names_are_the_same(self):
        for given in ({"light": {"up_mm": 2.5}}, {"light.up_mm": 2.5}, {"light.up_mm": np.float32(2.5)}):
            self.assertEqual(list(scene.options(given)), ["--light.up_mm=2.5"])
            self.assertEqual(scene.message(given, FIELDS).light.up_mm, 2.5)
        with self.assertRaisesRegex(TypeError, "light.up_mm is None"):
            scene.flat({"light": {"up_mm": None}})

    def test_choices_have_names(self):
        self.assertEqual(scene.message({"mode": "slice"}, FIELDS).mode, 1)
        self.assertEqual(scene.values(pb.Scene(mode=1), FIELDS)["mode"], "slice")
        self.assertEqual(scene.message({"finish": {"iterations": 3.0}}, FIELDS).finish.iterations, 3)
        self.assertEqual(scene.message({"cuts": {"shapes": "x"}}, FIELDS).cuts.shapes, "x")

    def test_what_the_server_does_not_know_is_named(self):
        for given, field, sentence in (
            ({"mode": "slcie"}, "mode", "expected surface, slice"),
            ({"light": {"up": 1}}, "light.up", "expected for example light.up_mm"),
            ({"light": {"up_mm": "high"}}, "light.up_mm", "expected a number"),
            ({"cuts": {"shapes": 3}}, "cuts.shapes", "expected a text"),
        ):
            with self.assertRaisesRegex(fanlight.ValueNotAllowed, sentence) as caught:
                scene.message(given, FIELDS)
            self.assertEqual(caught.exception.field, field)


class Addresses(unittest.TestCase):
    def test_forms(self):
        for given, stream in (
            ("8080", "ws://127.0.0.1:8080/stream"),
            ("scanner:8080", "ws://scanner:8080/stream"),
            ("https://scanner.example", "wss://scanner.example/stream"),
            ("https://host.example/theatre/3/", "wss://host.example/theatre/3/stream"),
            ("ws://[::1]:8080/stream", "ws://[::1]:8080/stream"),
        ):
            self.assertEqual(session.stream_address(given), stream)
        for wrong in ("ftp://scanner", "http://", ""):
            with self.assertRaisesRegex(ValueError, "expected http://HOST:PORT"):
                session.stream_address(wrong)


class Render(unittest.TestCase):
    def test_a_recording_has_pixels_depths_and_points(self):
        picture = fanlight.render(SOURCE, size=(96, 64), camera={"yaw_deg": 20.0})
        self.assertEqual(picture.rgb.shape, (64, 96, 3))
        self.assertEqual(picture.depth_mm.shape, (64, 96))
        self.assertAlmostEqual(np.isfinite(picture.depth_mm).mean(), picture.surface_share, places=2)
        self.assertGreater(picture.rgb[np.isfinite(picture.depth_mm)].mean(), 20)
        # The depth of a point along the view is its depth.
        depth = (picture.points_mm - picture.view.origin_mm) @ picture.view.forward
        np.testing.assert_allclose(depth, picture.depth_mm, atol=1e-3)
        self.assertFalse(picture.rgb.flags.writeable or picture.depth_mm.flags.writeable)
        self.assertEqual(picture._repr_png_()[1:4], b"PNG")

    def test_errors_have_names(self):
        with self.assertRaisesRegex(fanlight.RenderFailed, "there is no such file"):
            fanlight.render("nothing.igs.mha")
        with self.assertRaisesRegex(fanlight.ValueNotAllowed, "from -2000 to 2000"):
            fanlight.render(SOURCE, light={"up_mm": 1e6})
        with self.assertRaisesRegex(fanlight.ValueNotAllowed, "did you mean"):
            fanlight.render(SOURCE, lihgt={"up_mm": 1})
        with self.assertRaisesRegex(fanlight.ProgramMissing, "could not be started"):
            fanlight.render(SOURCE, program="/nothing")
        with self.assertRaisesRegex(fanlight.TimedOut, "within 0.01 s"):
            fanlight.render(SOURCE, timeout_s=0.01)
        with self.assertRaisesRegex(TypeError, "expected geometry="):
            fanlight.render(np.zeros((2, 2, 2), np.uint8))

    def test_leaves_no_file(self):
        with tempfile.TemporaryDirectory() as folder:
            before, tempfile.tempdir = tempfile.tempdir, folder
            try:
                array = np.zeros((2, 2, 2), np.uint8)
                with self.assertRaisesRegex(fanlight.RenderFailed, "faec"):
                    fanlight.render(array, fanlight.Fan(**FAN, angles_deg=[0, 1]), preset="faec")
                self.assertEqual(os.listdir(folder), [])
            finally:
                tempfile.tempdir = before


class Displays(unittest.IsolatedAsyncioTestCase):
    async def test_pictures_depths_and_pose(self):
        with served() as (url, _):
            async with fanlight.connect(url, codec="png", size=(256, 256), depth=True) as display:
                await display.freeze()
                picture = await display.picture()
                self.assertEqual((picture.state, picture.origin), ("frozen", "simulated"))
                self.assertEqual(picture.rgb.shape, (256, 256, 3))
                self.assertEqual(picture.depth_mm.shape, (512, 512))
                self.assertGreater(picture.age_s, 0)
                self.assertAlmostEqual(np.isfinite(picture.depth_mm).mean(), picture.surface_share, places=2)
                # A pixel of the small picture is the middle of four of the large one.
                small = picture.view.points_mm(np.full((256, 256), 50.0))
                large = picture.depth_view.points_mm(np.full((512, 512), 50.0))
                np.testing.assert_allclose(small[10, 20], large[20:22, 40:42].mean(axis=(0, 1)), atol=1e-6)
                request = pb.DepthRequest(pixels=[pb.DepthRequest.Pixel(column=250, row=260)])
                reply = (await display._session.ask("depth", request)).depth_reply
                told = reply.points[0]
                point = picture.points_mm[260, 250]
                np.testing.assert_allclose(point, [told.x_mm, told.y_mm, told.z_mm], atol=0.02)

    async def test_set_is_seen_and_own_view_is_own(self):
        with served() as (url, _):
            async with fanlight.connect(url) as display, fanlight.connect(url) as other:
                revision = await display.set(light={"up_mm": 17}, mode="surface")
                self.assertGreaterEqual((await display.picture()).scene_revision, revision)
                self.assertEqual(display.scene["light"]["up_mm"], 17)
                self.assertTrue(display.in_control)
                await other.set(own=True, camera={"yaw_deg": 50})
                self.assertTrue((await other.picture()).private_view)
                self.assertNotEqual(display.scene["camera"]["yaw_deg"], 50)
                with self.assertRaises(fanlight.ControlHeld):
                    await other.set(light={"up_mm": 3})
                self.assertFalse(await other.ask_control())
                await display.release_control()
                for _ in range(200):
                    if other.in_control:
                        break
                    await asyncio.sleep(0.02)
                self.assertTrue(other.in_control)
                await other.leave_own_view()
                self.assertFalse((await other.picture()).private_view)
                with self.assertRaises(fanlight.ValueNotAllowed) as caught:
                    await other.set(light={"up_mm": 1e6})
                self.assertEqual((caught.exception.field, caught.exception.maximum), ("light.up_mm", 2000))

    async def test_a_slow_reader_gets_the_newest(self):
        with served() as (url, _):
            async with fanlight.connect(url) as display:
                first = await display.picture()
                await asyncio.sleep(2)
                newest = [await display.picture() for _ in range(2)]
                self.assertGreater(display.skipped, 0)
                self.assertGreater(newest[0].picture_id, first.picture_id + 1)
                self.assertGreater(newest[1].picture_id, newest[0].picture_id)

    async def test_recordings(self):
        with served() as (url, _):
            async with fanlight.connect(url) as display:
                recording = await display.record()
                with self.assertRaises(fanlight.Refused):
                    await display.record()
                await asyncio.sleep(0.5)
                await recording.stop()
                self.assertRegex(recording.file, r"\.igs\.mha$")
                with self.assertRaises(RuntimeError):
                    async with display.record():
                        raise RuntimeError("ends the recording all the same")

    async def test_a_recording_without_frames_is_an_error(self):
        with served(source=f"{SOURCE},volumes=1") as (url, _):
            async with fanlight.connect(url) as display:
                while display.state.name != "not live":  # the source has ended
                    await asyncio.sleep(0.1)
                with self.assertRaisesRegex(fanlight.Refused, "no frame came"):
                    async with display.record():
                        pass

    async def test_a_server_that_ends_is_an_error(self):
        with served() as (url, process):
            async with fanlight.connect(url) as display:
                with self.assertRaisesRegex(fanlight.ConnectionLost, "server is stopping"):
                    async for _ in display:
                        process.terminate()
                with self.assertRaises(fanlight.ConnectionLost):
                    await display.set(light={"up_mm": 1})
        with self.assertRaisesRegex(fanlight.ConnectionFailed, "127.0.0.1"):
            async with fanlight.connect(url):
                self.fail("there is no server")

    async def test_a_stopped_server_times_out(self):
        with served() as (url, process):
            async with fanlight.connect(url, timeout_s=3) as display:
                await display.picture()
                process.send_signal(19)  # SIGSTOP
                try:
                    with self.assertRaises(fanlight.TimedOut):
                        while True:
                            await display.picture()
                    self.assertEqual(display.state.name, "not live")
                    self.assertRegex(display.state.sentence, "has sent nothing for")
                    with self.assertRaises(fanlight.TimedOut):
                        await display.set(light={"up_mm": 1})
                finally:
                    process.send_signal(18)  # SIGCONT

    async def test_tokens_and_roles(self):
        with tempfile.TemporaryDirectory() as folder:
            tokens = os.path.join(folder, "tokens.toml")
            command = [os.environ["FANLIGHT"], "token", "add", "--tokens", tokens, "--name", "ward"]
            token = subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()
            with served("--tokens", tokens) as (url, _):
                with self.assertRaisesRegex(fanlight.NotAuthenticated, "asks for a token"):
                    async with fanlight.connect(url):
                        self.fail("without a token")
                with self.assertRaisesRegex(fanlight.NotAuthenticated, "token"):
                    async with fanlight.connect(url, "wrong"):
                        self.fail("with a wrong token")
                await asyncio.sleep(1.2)  # longer than the pause after a wrong one
                async with fanlight.connect(url, token, name="round") as display:
                    self.assertEqual(display.role, "viewer")
                    await display.picture()
                    for request in (display.set(light={"up_mm": 1}), display.freeze(), display.find_surface()):
                        with self.assertRaises(fanlight.NotPermitted):
                            await request

    async def test_png_is_what_the_server_renders(self):
        with served() as (url, _):
            async with fanlight.connect(url, codec="png") as display:
                await display.freeze()
                await asyncio.sleep(1)  # until it does not become finer any more
                async for picture in display:
                    newest = picture
                    break
                with urllib.request.urlopen(f"{url}/api/picture.png") as answer:
                    from PIL import Image

                    exact = np.asarray(Image.open(answer).convert("RGB"))
                np.testing.assert_array_equal(newest.rgb, exact)


if __name__ == "__main__":
    unittest.main()
