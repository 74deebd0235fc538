"""Writes the corpus: one state of three grains, as other programs write it. Needs vtk and h5py; with --reference codes also yade, liggghts and lmp,
with --ovito the package ovito. Run in this folder; the test reads what is committed, not this script.

values.csv has the right values: grains by frame. files.csv lists the files, their writers, and what each of them states.
"""

import csv
import gzip
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
TIMES = [0.25, 0.5]
# id, type, x, y, z, radius, vx, vy, vz, wx, wy, wz
GRAINS = [
    [1, 1, 0.05, 0.0125, 0.02, 0.005, 0.5, -0.25, 1.0, 2.0, 4.0, -8.0],
    [2, 2, 0.05, 0.0215, 0.02, 0.004, 0.0, 0.75, -0.125, 0.0, -1.0, 0.5],
    [3, 1, -0.03, 0.0075, 0.045, 0.006, -1.5, 0.0, 0.0625, 3.0, 0.25, 0.0],
]
HEADS = ["id", "type", "x", "y", "z", "radius", "vx", "vy", "vz", "wx", "wy", "wz"]


def state(frame):
    """The grains of a frame: they have moved by their velocities times 0.001 s per frame."""
    return [row[:2] + [row[2 + axis] + 0.001 * frame * row[6 + axis] for axis in range(3)] + row[5:] for row in GRAINS]


listed = []


def note(file, writer, frames="0", states="id type radius v w", times=""):
    listed.append([file, writer, frames, states, times])


def write_values():
    with open(HERE / "values.csv", "w", newline="") as out:
        table = csv.writer(out, lineterminator="\n")
        table.writerow(["frame"] + HEADS)
        for frame in range(len(TIMES)):
            table.writerows([frame] + [f"{value:.9g}" for value in row] for row in state(frame))


def with_vtk():
    import vtk
    from vtk.util import numpy_support
    import numpy as np

    writer_name = f"VTK {vtk.vtkVersion.GetVTKVersion()}"

    def array(name, values, kind):
        made = numpy_support.numpy_to_vtk(np.array(values, dtype=kind), deep=1)
        made.SetName(name)
        return made

    def fill(data, rows, cells=True):
        points = vtk.vtkPoints()
        points.SetDataTypeToDouble()
        for row in rows:
            points.InsertNextPoint(row[2:5])
        data.SetPoints(points)
        of_points = data.GetPointData()
        of_points.AddArray(array("id", [row[0] for row in rows], np.int64))
        of_points.AddArray(array("type", [row[1] for row in rows], np.int32))
        of_points.AddArray(array("radius", [row[5] for row in rows], np.float64))
        of_points.AddArray(array("v", [row[6:9] for row in rows], np.float32))
        of_points.AddArray(array("omega", [row[9:12] for row in rows], np.float32))
        of_points.AddArray(array("stress", [[9.0] * 9] * len(rows), np.float32))
        return data

    def poly(frame=0, verts=True):
        rows = state(frame)
        data = fill(vtk.vtkPolyData(), rows)
        if verts:
            cells = vtk.vtkCellArray()
            for place in range(len(rows)):
                cells.InsertNextCell(1, [place])
            data.SetVerts(cells)
        return data

    def grid(frame=0):
        rows = state(frame)
        data = fill(vtk.vtkUnstructuredGrid(), rows)
        for place in range(len(rows)):
            data.InsertNextCell(vtk.VTK_VERTEX, 1, [place])
        return data

    def xml(data, file, mode, compressor, header=64, big=False):
        writer = vtk.vtkXMLPolyDataWriter() if data.IsA("vtkPolyData") else vtk.vtkXMLUnstructuredGridWriter()
        writer.SetFileName(str(HERE / file))
        writer.SetInputData(data)
        {"ascii": writer.SetDataModeToAscii, "inline": writer.SetDataModeToBinary}.get(
            mode, writer.SetDataModeToAppended
        )()
        writer.SetEncodeAppendedData(mode == "base64")
        {
            "none": writer.SetCompressorTypeToNone,
            "zlib": writer.SetCompressorTypeToZLib,
            "lz4": writer.SetCompressorTypeToLZ4,
            "lzma": writer.SetCompressorTypeToLZMA,
        }[compressor]()
        {32: writer.SetHeaderTypeToUInt32, 64: writer.SetHeaderTypeToUInt64}[header]()
        writer.SetByteOrderToBigEndian() if big else writer.SetByteOrderToLittleEndian()
        writer.SetBlockSize(64)
        assert writer.Write() == 1

    for kind, data in (("vtp", poly()), ("vtu", grid())):
        for mode in ("ascii", "inline", "raw", "base64"):
            for compressor in ("none", "zlib", "lz4"):
                if mode == "ascii" and compressor != "none":
                    continue
                header, big = (32, True) if (kind == "vtu") == (mode in ("inline", "base64")) else (64, False)
                file = f"xml-{mode}-{compressor}-{'big' if big else 'little'}-{header}.{kind}"
                xml(data, file, mode, compressor, header, big)
                note(file, writer_name)
    xml(poly(), "xml-inline-zlib-big-64.vtp", "inline", "zlib", 64, True)
    note("xml-inline-zlib-big-64.vtp", writer_name)
    xml(poly(verts=False), "xml-points-alone.vtp", "raw", "zlib", 32)
    note("xml-points-alone.vtp", writer_name)
    xml(poly(), "xml-lzma.vtp", "raw", "lzma")
    note("xml-lzma.vtp", writer_name, "refused: it is compressed by vtkLZMADataCompressor", "")

    # Numbers of all types, a text and a bit, some of which no column takes.
    data = poly()
    of_points = data.GetPointData()
    for name, kind in [("int8", np.int8), ("uint8", np.uint8), ("int16", np.int16), ("uint16", np.uint16), ("uint32", np.uint32)]:
        of_points.AddArray(array(name, [1, 2, 3], kind))
    of_points.AddArray(array("not_finite", [float("nan")] * 3, np.float64))
    words = vtk.vtkStringArray()
    words.SetName("words")
    bits = vtk.vtkBitArray()
    bits.SetName("bits")
    for place in range(3):
        words.InsertNextValue(f"grain {place}")
        bits.InsertNextValue(place % 2)
    of_points.AddArray(words)
    of_points.AddArray(bits)
    data.GetCellData().AddArray(array("of_cells", [1.0, 2.0, 3.0], np.float64))
    of_points.RemoveArray("id")
    of_points.AddArray(array("id", [1, 2, 3], np.uint64))
    of_points.RemoveArray("type")
    of_points.AddArray(array("type", [1, 2, 1], np.int8))
    for mode in ("ascii", "raw"):
        xml(data, f"xml-all-types-{mode}.vtp", mode, "none")
        note(f"xml-all-types-{mode}.vtp", writer_name)
    # Lines between the grains beside their vertices.
    lines = vtk.vtkCellArray()
    lines.InsertNextCell(2, [0, 1])
    both = poly()
    both.SetLines(lines)
    xml(both, "xml-vertices-and-lines.vtp", "raw", "zlib")
    note("xml-vertices-and-lines.vtp", writer_name)

    for kind, make, writer in (
        ("poly", poly, vtk.vtkPolyDataWriter),
        ("grid", grid, vtk.vtkUnstructuredGridWriter),
    ):
        for version in (42, 51):
            for mode in ("ascii", "binary"):
                legacy = writer()
                file = f"legacy-{kind}-{version}-{mode}.vtk"
                legacy.SetFileName(str(HERE / file))
                legacy.SetFileVersion(version)
                legacy.SetInputData(make())
                legacy.SetFileTypeToBinary() if mode == "binary" else legacy.SetFileTypeToASCII()
                assert legacy.Write() == 1
                note(file, writer_name)
    legacy = vtk.vtkPolyDataWriter()
    legacy.SetFileName(str(HERE / "legacy-all-types-binary.vtk"))
    legacy.SetInputData(data)
    legacy.SetFileTypeToBinary()
    legacy.Write()
    note("legacy-all-types-binary.vtk", writer_name)

    # Lists of files.
    blocks = vtk.vtkMultiBlockDataSet()
    blocks.SetBlock(0, poly())
    writer = vtk.vtkXMLMultiBlockDataWriter()
    writer.SetFileName(str(HERE / "blocks.vtm"))
    writer.SetInputData(blocks)
    writer.Write()
    shutil.rmtree(HERE / "blocks")
    note("blocks.vtm", writer_name, "refused: it is a list of blocks (.vtm)", "")
    writer = vtk.vtkXMLPPolyDataWriter()
    writer.SetFileName(str(HERE / "pieces.pvtp"))
    writer.SetInputData(poly())
    writer.SetNumberOfPieces(1)
    writer.Write()
    for piece in HERE.glob("pieces_*.vtp"):
        piece.unlink()
    for piece in HERE.glob("pieces/*"):
        piece.unlink()
    note("pieces.pvtp", writer_name, "refused: it is a list of pieces (.pvtp)", "")

    # VTKHDF, of one frame and of two; packed, since the writer leaves much empty space.
    def pack(file):
        (HERE / f"{file}.gz").write_bytes(gzip.compress((HERE / file).read_bytes(), mtime=0))
        (HERE / file).unlink()

    for kind, make in (("poly", poly), ("grid", grid)):
        writer = vtk.vtkHDFWriter()
        writer.SetFileName(str(HERE / f"hdf-{kind}.vtkhdf"))
        writer.SetInputData(make())
        writer.SetCompressionLevel(0 if kind == "poly" else 4)
        writer.SetChunkSize(16)
        assert writer.Write() == 1
        pack(f"hdf-{kind}.vtkhdf")
        note(f"hdf-{kind}.vtkhdf.gz", writer_name)

    from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase

    class Source(VTKPythonAlgorithmBase):
        def __init__(self, make, kind):
            VTKPythonAlgorithmBase.__init__(self, nInputPorts=0, nOutputPorts=1, outputType=kind)
            self.make = make

        def RequestInformation(self, request, inputs, outputs):
            info = outputs.GetInformationObject(0)
            info.Set(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS(), TIMES, len(TIMES))
            info.Set(vtk.vtkStreamingDemandDrivenPipeline.TIME_RANGE(), [TIMES[0], TIMES[-1]], 2)
            return 1

        def RequestData(self, request, inputs, outputs):
            info = outputs.GetInformationObject(0)
            key = vtk.vtkStreamingDemandDrivenPipeline.UPDATE_TIME_STEP()
            time = info.Get(key) if info.Has(key) else TIMES[0]
            frame = min(range(len(TIMES)), key=lambda place: abs(TIMES[place] - time))
            output = vtk.vtkDataObject.GetData(info)
            output.ShallowCopy(self.make(frame))
            output.GetInformation().Set(vtk.vtkDataObject.DATA_TIME_STEP(), TIMES[frame])
            return 1

    for kind, make in (("poly", poly), ("grid", grid)):
        source = Source(make, "vtkPolyData" if kind == "poly" else "vtkUnstructuredGrid")
        writer = vtk.vtkHDFWriter()
        writer.SetFileName(str(HERE / f"hdf-{kind}-two-frames.vtkhdf"))
        writer.SetInputConnection(source.GetOutputPort())
        writer.SetWriteAllTimeSteps(True)
        writer.SetChunkSize(4)
        assert writer.Write() == 1
        pack(f"hdf-{kind}-two-frames.vtkhdf")
        note(f"hdf-{kind}-two-frames.vtkhdf.gz", writer_name, "0 1", times="0.25 0.5")


def with_h5py():
    import h5py
    import numpy as np

    writer_name = f"h5py {h5py.__version__}"

    def file(name, libver="earliest"):
        out = h5py.File(HERE / name, "w", libver=libver)
        root = out.create_group("VTKHDF")
        root.attrs["Version"] = [2, 3]
        root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", 8))
        return out, root

    def topology(root, points, parts):
        for name in ("Vertices", "Lines", "Polygons", "Strips"):
            counts = points if name == "Vertices" else [0] * parts
            group = root.create_group(name)
            group["NumberOfCells"] = np.array(counts, "i8")
            group["NumberOfConnectivityIds"] = np.array(counts, "i8")
            group["Offsets"] = np.concatenate([np.arange(count + 1) for count in counts]).astype("i8")
            group["Connectivity"] = np.concatenate([np.arange(count) for count in counts] + [[]]).astype("i8")

    def steps(root, parts, each, first_points, names, offsets):
        group = root.create_group("Steps")
        group.attrs["NSteps"] = len(TIMES)
        group["Values"] = TIMES
        group["PartOffsets"] = np.array(parts, "i8")
        if each is not None:
            group["NumberOfParts"] = np.array(each, "i8")
        group["PointOffsets"] = np.array(first_points, "i8")
        group["CellOffsets"] = np.zeros((2, 4), "i8")
        group["ConnectivityIdOffsets"] = np.zeros((2, 4), "i8")
        for name in names:
            group[f"PointDataOffsets/{name}"] = np.array(offsets, "i8")

    def column(rows, start, end=None):
        return [row[start:end] if end else row[start] for row in rows]

    both = [state(0), state(1)]
    flat = both[0] + both[1]
    # Places that rest are written once; the arrays of the second frame follow those of the first.
    out, root = file("hdf-still.vtkhdf")
    with out:
        root["NumberOfPoints"] = np.array([3], "i8")
        root["Points"] = np.array(column(both[0], 2, 5), "f8")
        topology(root, [3], 1)
        root["PointData/radius"] = np.array(column(both[0], 5), "f4")
        root["PointData/id"] = np.array(column(both[0], 0), "u8")
        root["PointData/v"] = np.array([[9.0, 9.0, 9.0]] + column(flat, 6, 9), "f4")
        steps(root, [0, 0], [1, 1], [0, 0], ["v"], [1, 4])
    note("hdf-still.vtkhdf", writer_name, "0 0", "id radius v", "0.25 0.5")
    # Two parts per frame, in the layout of HDF5 1.10; parts are as many in each step, and their number is left out.
    out, root = file("hdf-parts.vtkhdf", ("v110", "v110"))
    with out:
        root["NumberOfPoints"] = np.array([2, 1, 1, 2], "i4")
        root.create_dataset("Points", data=np.array(column(flat, 2, 5), "f8"), chunks=(4, 3), compression="gzip", shuffle=True)
        topology(root, [2, 1, 1, 2], 4)
        of_points = root.create_group("PointData")
        of_points.create_dataset("diameter", data=2 * np.array(column(flat, 5), ">f8"))
        of_points.create_dataset("type", data=np.array(column(flat, 1), "i2"))
        of_points.create_dataset("id", data=np.array(column(flat, 0), "u4"), chunks=(4,), compression="gzip", fletcher32=True)
        of_points.create_dataset("velocity", data=np.array(column(flat, 6, 9), "f4"))
        of_points.create_dataset("name", data=["a"] * 6, dtype=h5py.string_dtype())
        steps(root, [0, 2], None, [0, 3], [], [])
    note("hdf-parts.vtkhdf", writer_name, "0 1", "id type radius v", "0.25 0.5")


def dump_rows(frame, columns):
    places = {name: place for place, name in enumerate(HEADS)}
    return [" ".join(f"{row[places[name]]:.9g}" for name in columns) for row in state(frame)]


def run(command, text, file, folder):
    (folder / file).write_text(text)
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


ATOMS = "".join(
    f"create_atoms {row[1]} single {row[2]} {row[3]} {row[4]} units box\n" for row in GRAINS
)


def with_lammps(folder):
    version = subprocess.run(["lmp", "-help"], capture_output=True, text=True).stdout
    version = "LAMMPS " + version.split("Parallel Simulator - ")[1].splitlines()[0].strip()
    sets = "".join(
        f"set atom {row[0]} diameter {2 * row[5]} density 2500\nset atom {row[0]} omega {row[9]} {row[10]} {row[11]}\n"
        f"set atom {row[0]} vx {row[6]}\nset atom {row[0]} vy {row[7]}\nset atom {row[0]} vz {row[8]}\n"
        for row in GRAINS
    )
    text = (
        "units si\natom_style sphere\nboundary p f f\ncomm_modify vel yes\nregion box block -0.1 0.1 -0.1 0.1 -0.1 0.1\ncreate_box 2 box\n"
        + ATOMS
        + sets
        + "pair_style granular\npair_coeff * * hooke 1e3 10 tangential linear_nohistory 1 0.5\ntimestep 1e-6\nfix nve all nve/sphere\n"
        "dump plain all custom 1 lammps.dump id type x y z radius vx vy vz omegax omegay omegaz\n"
        "dump_modify plain format float %.12g sort id\n"
        "dump told all custom 1 lammps-units-time.dump type id element diameter xu yu zu vx vy vz omegax omegay omegaz\n"
        "dump_modify told units yes time yes element Si C format float %.12g\n"
        "dump scaled all custom 1 lammps-scaled.dump id type xs ys zs radius\n"
        "dump packed all custom/gz 1 lammps.dump.gz id type x y z radius vx vy vz omegax omegay omegaz\n"
        "dump_modify packed format float %.12g\n"
        "dump bare all atom 1 lammps-atom.dump\n"
        "run 0\nwrite_data lammps.data\nwrite_dump all xyz lammps.xyz\n"
    )
    run(["lmp", "-in", "in.lammps", "-log", "none"], text, "in.lammps", folder)
    note("lammps.dump", version)
    note("lammps-units-time.dump", version, times="0")
    note("lammps.dump.gz", version)
    note("lammps-scaled.dump", version, "refused: coordinates are scaled to the box", "")
    note("lammps-atom.dump", version, "refused: coordinates are scaled to the box", "")
    note("lammps.data", version, "refused: it is a data file of LAMMPS", "")
    note("lammps.xyz", version, "refused: it begins with a count, as XYZ files do", "")


def with_liggghts(folder):
    version = subprocess.run(["liggghts", "-help", "-log", "none"], capture_output=True, text=True).stdout
    version = "LIGGGHTS " + version.split("LIGGGHTS-PUBLIC ")[1].split(",")[0].split(" ")[0]
    sets = "".join(
        f"set atom {row[0]} diameter {2 * row[5]} density 2500\nset atom {row[0]} omegax {row[9]} omegay {row[10]} omegaz {row[11]}\n"
        f"set atom {row[0]} vx {row[6]} vy {row[7]} vz {row[8]}\n"
        for row in GRAINS
    )
    text = (
        "atom_style granular\natom_modify map array\nboundary p f f\nnewton off\ncommunicate single vel yes\nunits si\n"
        "region box block -0.1 0.1 -0.1 0.1 -0.1 0.1 units box\ncreate_box 2 box\nneighbor 0.001 bin\n"
        + ATOMS
        + sets
        + "fix m1 all property/global youngsModulus peratomtype 1e7 1e7\nfix m2 all property/global poissonsRatio peratomtype 0.3 0.3\n"
        "fix m3 all property/global coefficientRestitution peratomtypepair 2 0.5 0.5 0.5 0.5\n"
        "fix m4 all property/global coefficientFriction peratomtypepair 2 0.5 0.5 0.5 0.5\n"
        "pair_style gran model hertz tangential history\npair_coeff * *\ntimestep 1e-7\nfix integrate all nve/sphere\n"
        "compute fc all pair/gran/local id force contactPoint\n"
        "dump plain all custom 1 liggghts.dump id type x y z radius vx vy vz omegax omegay omegaz\n"
        'dump_modify plain format "%d %d %.12g %.12g %.12g %.12g %.12g %.12g %.12g %.12g %.12g %.12g"\n'
        "dump pairs all local 1 liggghts-pairs.dump c_fc[1] c_fc[2] c_fc[3] c_fc[4] c_fc[5] c_fc[6] c_fc[7] c_fc[8] c_fc[9]\n"
        "dump vtk all custom/vtk 1 liggghts-*.vtk id type x y z radius vx vy vz omegax omegay omegaz\n"
        "dump vtp all custom/vtk 1 liggghts-*.vtp id type x y z radius vx vy vz omegax omegay omegaz\n"
        "run 0\n"
    )
    run(["liggghts", "-in", "in.liggghts", "-log", "none"], text, "in.liggghts", folder)
    # One compute of contacts is allowed per run.
    places = text.replace("compute fc all pair/gran/local id force contactPoint", "compute fp all pair/gran/local pos id force")
    head, rest = places.split("dump plain")[0], "dump places all local 1 liggghts-places.dump "
    rest += " ".join(f"c_fp[{place}]" for place in range(1, 13)) + "\nrun 0\n"
    run(["liggghts", "-in", "in.places", "-log", "none"], head + rest, "in.places", folder)
    note("liggghts.dump", version)
    note("liggghts-pairs.dump", version, "contacts c_fc:first,second,_,fx,fy,fz,px,py,pz", "")
    note("liggghts-places.dump", version, "contacts c_fp:_,_,_,_,_,_,first,second,_,fx,fy,fz", "")
    for name in ("liggghts-0.vtk", "liggghts-0.vtp"):
        if (folder / name).exists():
            note(name, version)


def with_yade(folder):
    version = subprocess.run(["yade", "--version"], capture_output=True, text=True)
    version = "YADE " + (version.stdout + version.stderr).split("version:")[1].split()[0].strip(",")
    bodies = "".join(
        f"b = sphere(({row[2]}, {row[3]}, {row[4]}), {row[5]}, material=m[{row[1] - 1}])\n"
        f"b.state.vel = ({row[6]}, {row[7]}, {row[8]})\nb.state.angVel = ({row[9]}, {row[10]}, {row[11]})\nO.bodies.append(b)\n"
        for row in GRAINS
    )
    text = (
        "from yade import export\n"
        "m = [O.materials.append(FrictMat(young=1e7, poisson=0.3, density=2500, frictionAngle=0.5, label=n)) for n in ('one', 'two')]\n"
        + bodies
        + "O.engines = [VTKRecorder(fileName='yade-', recorders=['spheres', 'velocity', 'id', 'materialId'], iterPeriod=1, firstIterRun=1),\n"
        "    VTKRecorder(fileName='yade-ascii-', recorders=['spheres', 'velocity', 'id', 'materialId'], ascii=True, compress=False, iterPeriod=1,\n"
        "        firstIterRun=1)]\n"
        "O.dt = 1e-9\nO.run(2, True)\n"
        "export.text('yade-text.txt')\n"
        "export.textExt('yade-format.txt', format='x_y_z_r_matId')\n"
        "e = export.VTKExporter('yade-export')\n"
        "e.exportSpheres(what=dict(v='b.state.vel', omega='b.state.angVel', id='b.id', material='b.mat.id'))\n"
        "import os\nos._exit(0)\n"
    )
    run(["yade", "-j1", "-n", "-x", "in.py"], text, "in.py", folder)
    renamed = {
        "yade-spheres.1.vtu": "id-0 type-0 radius v w",
        "yade-ascii-spheres.1.vtu": "id-0 type-0 radius v w",
        "yade-text.txt": "radius",
        "yade-format.txt": "type-0 radius",
        "yade-export-spheres-00000000.vtk": "id-0 type-0 radius v w",
    }
    for name, states in renamed.items():
        if (folder / name).exists():
            note(name, version, states=states)
        else:
            print("yade has not written", name, sorted(path.name for path in folder.glob("yade*")))


def with_ovito(folder):
    import ovito
    from ovito.io import export_file, import_file

    version = f"OVITO {ovito.version_string}"
    columns = ["Particle Identifier", "Particle Type", "Position.X", "Position.Y", "Position.Z", "Radius"]
    columns += [f"Velocity.{axis}" for axis in "XYZ"] + [f"Angular Velocity.{axis}" for axis in "XYZ"]
    pipeline = import_file(str(HERE / "lammps.dump"))
    export_file(pipeline, str(folder / "ovito.dump"), "lammps/dump", columns=columns)
    note("ovito.dump", version)
    export_file(pipeline, str(folder / "ovito.xyz"), "xyz", columns=columns[:6])
    note("ovito.xyz", version, "refused: it begins with a count, as XYZ files do", "")
    export_file(pipeline, str(folder / "ovito.data"), "lammps/data", atom_style="sphere")
    note("ovito.data", version, "refused: it is a data file of LAMMPS", "")
    export_file(pipeline, str(folder / "ovito.gsd"), "gsd/hoomd")
    note("ovito.gsd", version, "refused: it is a GSD file", "")


def main():
    for old in HERE.iterdir():
        if old.is_file() and old.suffix not in (".py", ".md"):
            old.unlink()
    write_values()
    with_vtk()
    with_h5py()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for option, made in {"--codes": (with_lammps, with_liggghts, with_yade), "--ovito": (with_ovito,)}.items():
            for make in made if option in sys.argv else ():
                make(folder)
                for name in {row[0] for row in listed}:
                    if (folder / name).exists():
                        shutil.copy(folder / name, HERE / name)
    with open(HERE / "files.csv", "w", newline="") as out:
        table = csv.writer(out, lineterminator="\n")
        table.writerow(["file", "writer", "frames", "states", "times"])
        table.writerows(sorted(listed))


main()
