"""Renderers that users would pick instead, on a field that `hypertexture field` writes: the lit surface of a teapot.

    pip install numpy vtk pygfx rendercanvas
    hypertexture field teapot --resolution 128 -o teapot.npy
    python3 benches/peers/surface.py teapot.npy
    hypertexture explain teapot --effect lit --resolution 128 --samples 256 --size 512x512

Milliseconds of a frame, wall and processor, medians of 9, while the object turns: the surface covers about as many pixels
as ours. Light and material are each renderer's own.
"""

import statistics
import sys
import time

import numpy

SIDE = 512
SAMPLES = 256
FRAMES = 9


def report(name, draw, turn):
    """Draws once for what is made once, and then times frames."""
    draw()
    wall, processor = [], []
    for _ in range(FRAMES):
        turn()
        start = time.perf_counter(), time.process_time()
        draw()
        wall.append(time.perf_counter() - start[0])
        processor.append(time.process_time() - start[1])
    wall, processor = (1e3 * statistics.median(times) for times in (wall, processor))
    print(f"{name:<40} {wall:8.1f} ms {processor:8.1f} ms of the processor")


def vtk_mapper(levels, name, mapper):
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk

    depth, height, width = levels.shape
    image = vtk.vtkImageData()
    image.SetDimensions(width, height, depth)
    image.GetPointData().SetScalars(numpy_to_vtk((levels * 65535).astype(numpy.uint16).ravel(), deep=1))
    mapper.SetInputData(image)
    mapper.AutoAdjustSampleDistancesOff()
    mapper.SetSampleDistance(numpy.linalg.norm(levels.shape) / SAMPLES)
    opacity = vtk.vtkPiecewiseFunction()
    for level, alpha in [(0, 0), (32767, 0), (32768, 1), (65535, 1)]:
        opacity.AddPoint(level, alpha)
    material = vtk.vtkVolumeProperty()
    material.SetScalarOpacity(opacity)
    material.ShadeOn()
    material.SetInterpolationTypeToLinear()
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(material)
    scene = vtk.vtkRenderer()
    scene.AddVolume(volume)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(SIDE, SIDE)
    window.AddRenderer(scene)
    scene.ResetCamera()
    scene.GetActiveCamera().Elevation(25)
    scene.GetActiveCamera().Zoom(2.1)

    def draw():
        window.Render()
        window.WaitForCompletion()

    report(name, draw, lambda: scene.GetActiveCamera().Azimuth(7))


def pygfx_volume(levels):
    import pygfx
    from rendercanvas.offscreen import OffscreenRenderCanvas

    canvas = OffscreenRenderCanvas(size=(SIDE, SIDE), pixel_ratio=1)
    renderer = pygfx.renderers.WgpuRenderer(canvas)
    geometry = pygfx.Geometry(grid=pygfx.Texture(levels, dim=3))
    volume = pygfx.Volume(geometry, pygfx.VolumeIsoMaterial(threshold=0.5, step_size=max(levels.shape) * 2 / SAMPLES, clim=(0, 1)))
    scene = pygfx.Scene()
    scene.add(volume, pygfx.AmbientLight(), pygfx.DirectionalLight())
    camera = pygfx.PerspectiveCamera(50, 1)
    camera.show_object(scene, view_dir=(-1, -0.5, -1), up=(0, 1, 0), scale=0.6)
    canvas.request_draw(lambda: renderer.render(scene, camera))
    turned = 0.0

    def turn():
        nonlocal turned
        turned += 0.1
        volume.local.rotation = (0, numpy.sin(turned), 0, numpy.cos(turned))

    report("pygfx on " + renderer.device.adapter.info["device"], canvas.draw, turn)


def main():
    import vtk

    field = numpy.load(sys.argv[1])
    levels = numpy.clip(0.5 - 2 * field, 0, 1).astype(numpy.float32)
    fixed = vtk.vtkFixedPointVolumeRayCastMapper()
    vtk_mapper(levels, f"VTK {vtk.vtkVersion().GetVTKVersion()}, fixed point, processor", fixed)
    vtk_mapper(levels, "VTK, mapper of a GPU, whichever there is", vtk.vtkGPUVolumeRayCastMapper())
    pygfx_volume(levels)


main()
