// VTK's smoothing of meshes by a windowed sinc filter (Taubin, Zhang, Golub 1996), for the
// benchmarks.
//   peer_vtk_smooth in.ply out.ply PASS_BAND ITERATIONS
// in: binary little-endian PLY, vertices first, then triangles alone as `list uchar int`. Boundary
// vertices stay; vertices keep their order. One JSON object on stdout.
#include "tests/peers/plain_points.h"

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkWindowedSincPolyDataFilter.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string>

namespace {

using Triangles = std::vector<std::array<std::int32_t, 3>>;

/// What follows the vertices to the end of the file.
Triangles read_triangles(const std::string& path) {
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    const auto size = std::size_t(in.tellg());
    in.seekg(0);
    std::string line;
    std::size_t n = 0;
    while (std::getline(in, line) && line != "end_header")
        if (line.rfind("element face ", 0) == 0) n = std::stoul(line.substr(13));
    if (n == 0 || size < 13 * n) throw std::runtime_error(path + ": no triangles to read");
    in.seekg(std::streamoff(size - 13 * n));
    Triangles triangles(n);
    for (auto& t : triangles)
        if (in.get() != 3 || !in.read(reinterpret_cast<char*>(t.data()), 12))
            throw std::runtime_error(path +
                                     ": faces are no list of uchar and int, or no triangles");
    return triangles;
}

vtkNew<vtkPolyData> mesh_of(const peers::Positions& points, const Triangles& triangles) {
    vtkNew<vtkPoints> vertices;
    vertices->SetDataTypeToDouble();
    for (const auto& p : points) vertices->InsertNextPoint(p.data());
    vtkNew<vtkCellArray> faces;
    for (const auto& t : triangles) {
        const vtkIdType ids[3] = {t[0], t[1], t[2]};
        faces->InsertNextCell(3, ids);
    }
    vtkNew<vtkPolyData> mesh;
    mesh->SetPoints(vertices);
    mesh->SetPolys(faces);
    return mesh;
}

int run(char** argv) {
    auto points = peers::read_positions(argv[1]);
    const auto mesh = mesh_of(points, read_triangles(argv[1]));
    vtkNew<vtkWindowedSincPolyDataFilter> filter;
    filter->SetInputData(mesh);
    filter->SetPassBand(std::stod(argv[3]));
    filter->SetNumberOfIterations(std::stoi(argv[4]));
    filter->BoundarySmoothingOff();
    filter->NormalizeCoordinatesOn();
    const auto start = std::chrono::steady_clock::now();
    filter->Update();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    for (std::size_t i = 0; i < points.size(); ++i)
        filter->GetOutput()->GetPoint(vtkIdType(i), points[i].data());
    if (!peers::write_positions(argv[2], points)) return 4;
    std::printf("{\"method\": \"windowed_sinc\", \"vertices\": %zu, \"method_seconds\": %.6f}\n",
                points.size(), seconds.count());
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 5) {
        std::fprintf(stderr, "usage: peer_vtk_smooth in.ply out.ply PASS_BAND ITERATIONS\n");
        return 2;
    }
    try {
        return run(argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 3;
    }
}
