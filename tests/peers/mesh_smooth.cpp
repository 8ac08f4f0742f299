// CGAL's smoothing of meshes by mean curvature flow (smooth_shape), for the benchmarks.
//   peer_mesh_smooth in.ply out.ply STEP ITERATIONS
// STEP is the time of one iteration over the square of the mesh's mean edge, so that it means the
// same for all meshes. Vertices of boundaries stay, vertices keep their order. One JSON object on
// stdout.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/Polygon_mesh_processing/smooth_shape.h>
#include <CGAL/Surface_mesh.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

double mean_edge(const Mesh& mesh) {
    double sum = 0;
    for (const auto e : mesh.edges())
        sum += std::sqrt(
            CGAL::squared_distance(mesh.point(mesh.vertex(e, 0)), mesh.point(mesh.vertex(e, 1))));
    return sum / double(mesh.number_of_edges());
}

void smooth(Mesh& mesh, double step, unsigned iterations) {
    const double edge = mean_edge(mesh);
    bool open = false;
    auto fixed = mesh.add_property_map<Mesh::Vertex_index, bool>("v:fixed", false).first;
    for (const auto v : mesh.vertices()) {
        fixed[v] = mesh.is_border(v);
        open = open || fixed[v];
    }
    const auto options = CGAL::parameters::number_of_iterations(iterations);
    const double time = step * edge * edge;
    // Without fixed vertices CGAL gives a closed mesh its volume back.
    if (open)
        CGAL::Polygon_mesh_processing::smooth_shape(mesh, time,
                                                    options.vertex_is_constrained_map(fixed));
    else
        CGAL::Polygon_mesh_processing::smooth_shape(mesh, time, options);
    mesh.remove_property_map(fixed);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 5) {
        std::fprintf(stderr, "usage: peer_mesh_smooth in.ply out.ply STEP ITERATIONS\n");
        return 2;
    }
    Mesh mesh;
    std::ifstream in(argv[1], std::ios::binary);
    if (!in || !CGAL::IO::read_PLY(in, mesh) || mesh.number_of_faces() == 0) {
        std::fprintf(stderr, "%s: no mesh of manifold faces to read\n", argv[1]);
        return 3;
    }
    const auto start = std::chrono::steady_clock::now();
    smooth(mesh, std::stod(argv[3]), unsigned(std::stoul(argv[4])));
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::ofstream out(argv[2], std::ios::binary);
    CGAL::IO::set_binary_mode(out);
    if (!CGAL::IO::write_PLY(out, mesh)) return 4;
    std::printf("{\"method\": \"smooth_shape\", \"vertices\": %zu, \"method_seconds\": %.6f}\n",
                std::size_t(mesh.number_of_vertices()), seconds.count());
    return 0;
}
