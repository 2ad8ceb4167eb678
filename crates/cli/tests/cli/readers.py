"""Reads meshes and volumes by programs that others wrote, and says what they find.

Role: `python3 tests/readers.py FOLDER` prints one JSON object a line for each file and reader; tests/readers.rs compares
them. Invariant: places are in RAS, x to the right and y to the front. ITK gives all files in LPS; that is turned back.
Ends with 77 where a package is missing, with 1 where a file cannot be read.
"""

import importlib.util
import json
import sys
from pathlib import Path

PACKAGES = {name: name for name in ("trimesh", "SimpleITK", "nibabel", "numpy", "scipy", "networkx")} | {"nrrd": "pynrrd"}


def imported(name):
    """The module, or None where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


MODULES = {name: imported(name) for name in PACKAGES}
np, nrrd, nibabel, trimesh, itk = (MODULES[name] for name in ("numpy", "nrrd", "nibabel", "trimesh", "SimpleITK"))
# It has two names, and is loaded for a file of its own: one made for an older numpy ends the program.
VDB = next((name for name in ("openvdb", "pyopenvdb") if importlib.util.find_spec(name)), None)


def of_mesh(path):
    """Corners at the same place are one, so that "watertight" speaks of the surface and not of how it is stored."""
    mesh = trimesh.load(path, force="mesh", process=True)
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    return {
        "vertices": len(mesh.vertices),
        "triangles": len(mesh.faces),
        "watertight": bool(mesh.is_watertight),
        "winding_consistent": bool(mesh.is_winding_consistent),
        "volume": float(mesh.volume),
        "bodies": int(mesh.body_count),
        "low": mesh.bounds[0].tolist(),
        "high": mesh.bounds[1].tolist(),
    }


def of_volume(values, origin=None, steps=None):
    """Values by x, y, z; steps are those along x, y and z, in world units. The moments are the sums of value * x, of
    value * y and of value * z, in samples: they tell the order of the axes."""
    values = np.asarray(values, dtype=np.float64)
    if values.ndim != 3:
        raise ValueError(f"{values.ndim} axes, not 3")
    along = [values.sum(axis=tuple({0, 1, 2} - {axis})) for axis in range(3)]
    return {
        "size": values.shape,
        "origin": None if origin is None else np.asarray(origin).tolist(),
        "steps": None if steps is None else np.asarray(steps).tolist(),
        "min": float(values.min()),
        "max": float(values.max()),
        "sum": float(values.sum()),
        "moments": [float(sums @ np.arange(len(sums))) for sums in along],
    }


def by_pynrrd(path):
    values, header = nrrd.read(str(path), index_order="F")
    return of_volume(values, header["space origin"], header["space directions"])


def by_itk(path):
    image = itk.ReadImage(str(path))
    origin = np.array(image.GetOrigin())
    steps = np.array(image.GetDirection()).reshape(3, 3).T * np.array(image.GetSpacing())[:, None]
    turn = [-1, -1, 1]
    return of_volume(itk.GetArrayViewFromImage(image).T, origin * turn, steps * turn)


def by_nibabel(path):
    image = nibabel.load(path)
    return of_volume(image.get_fdata(), image.affine[:3, 3], image.affine[:3, :3].T)


def by_numpy(path):
    """No places: the format has none. Its last axis is x."""
    return of_volume(np.load(path).T)


def by_openvdb(path):
    """The box of the active voxels of the first grid."""
    grid = importlib.import_module(VDB).readAll(str(path))[0][0]
    low, high = grid.evalActiveVoxelBoundingBox()
    values = np.zeros([last - first + 1 for first, last in zip(low, high)])
    grid.copyToArray(values, ijk=low)
    beside = [tuple(np.add(low, unit).tolist()) for unit in np.eye(3, dtype=int)]
    origin, *ends = (np.array(grid.transform.indexToWorld(place)) for place in (low, *beside))
    return of_volume(values, origin, [end - origin for end in ends])


READERS = {
    ".nrrd": {"pynrrd": by_pynrrd, "SimpleITK": by_itk},
    ".mha": {"SimpleITK": by_itk},
    ".nii": {"nibabel": by_nibabel, "SimpleITK": by_itk},
    ".nii.gz": {"nibabel": by_nibabel, "SimpleITK": by_itk},
    ".npy": {"numpy": by_numpy},
    ".vdb": {"openvdb": by_openvdb} if VDB else {},
} | {end: {"trimesh": of_mesh} for end in (".stl", ".ply", ".obj", ".glb")}


def main(arguments):
    if len(arguments) != 1 or not Path(arguments[0]).is_dir():
        sys.exit("usage: python3 tests/readers.py FOLDER")
    missing = [PACKAGES[name] for name, module in MODULES.items() if module is None]
    if missing:
        print(f"missing: {', '.join(missing)}; pip install {' '.join(PACKAGES.values())}", file=sys.stderr)
        return 77
    status = 0
    for path in sorted(Path(arguments[0]).iterdir()):
        readers = next((readers for end, readers in READERS.items() if path.name.lower().endswith(end)), {})
        for reader, read in readers.items():
            try:
                found = {"file": path.name, "reader": reader, **read(path)}
                print(json.dumps(found, allow_nan=False))
            except Exception as error:  # whatever a reader raises is its answer
                print(f"{path.name}: {reader} cannot read it: {' '.join(str(error).split())}", file=sys.stderr)
                status = 1
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
