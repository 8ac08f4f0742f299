// A mesh decimated by Garland and Heckbert's quadrics (CGAL), and how far the original vertices lie
// from it.
//
//   peer_decimate MESH_OR_CLOUD.ply FACES...
//
// A cloud without faces is meshed first, through its own points (advancing front). Prints one line
// of JSON for every number of faces: faces, vertices, and over the diagonal of the vertices'
// bounding box the RMS and the largest distance to the mesh, and the RMS distance to the mesh with
// its coordinates rounded to 16 bits.
#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Bbox_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_placement.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <vector>

namespace {

namespace sms = CGAL::Surface_mesh_simplification;
namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Primitive = CGAL::AABB_face_graph_triangle_primitive<Mesh>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;
using Faces = std::vector<std::vector<std::size_t>>;

// Faces through the points themselves: every vertex of the mesh is a point of the cloud.
Faces meshed(const std::vector<Point>& points) {
    std::vector<std::array<std::size_t, 3>> triangles;
    CGAL::advancing_front_surface_reconstruction(points.begin(), points.end(),
                                                 std::back_inserter(triangles));
    Faces faces;
    for (const auto& t : triangles) faces.push_back({t[0], t[1], t[2]});
    return faces;
}

Mesh mesh_of(std::vector<Point> points, Faces faces) {
    Mesh mesh;
    pmp::orient_polygon_soup(points, faces);
    pmp::polygon_soup_to_polygon_mesh(points, faces, mesh);
    pmp::remove_isolated_vertices(mesh);
    mesh.collect_garbage();
    return mesh;
}

std::vector<Point> vertices_of(const Mesh& mesh) {
    std::vector<Point> points;
    for (const auto v : mesh.vertices()) points.push_back(mesh.point(v));
    return points;
}

struct Distances {
    double rms, max;
};

Distances distances(const std::vector<Point>& points, const Mesh& mesh) {
    Tree tree(faces(mesh).begin(), faces(mesh).end(), mesh);
    tree.accelerate_distance_queries();
    double sum = 0, largest = 0;
    for (const Point& p : points) {
        const double sq = CGAL::to_double(tree.squared_distance(p));
        sum += sq;
        largest = std::max(largest, sq);
    }
    return {std::sqrt(sum / double(points.size())), std::sqrt(largest)};
}

void round_to_16_bits(Mesh& mesh, const CGAL::Bbox_3& box) {
    for (const auto v : mesh.vertices()) {
        std::array<double, 3> rounded{};
        for (int i = 0; i < 3; ++i) {
            const double step = (box.max(i) - box.min(i)) / 65535;
            const double from = mesh.point(v)[i] - box.min(i);
            rounded[std::size_t(i)] = box.min(i) + step * std::round(from / step);
        }
        mesh.point(v) = Point(rounded[0], rounded[1], rounded[2]);
    }
}

// "Stop" is asked before every collapse: the sweep takes its pictures of the mesh there, in one
// run.
struct Sweep {
    std::vector<std::size_t>* targets;  // rising; the last is due next
    const std::function<void(Mesh)>* take;

    template <class Cost, class Profile>
    bool operator()(const Cost&, const Profile& profile, std::size_t, std::size_t) const {
        const Mesh& mesh = profile.surface_mesh();
        while (!targets->empty() && mesh.number_of_faces() <= targets->back()) {
            (*take)(mesh);
            targets->pop_back();
        }
        return targets->empty();
    }
};

void decimate(Mesh& mesh, std::vector<std::size_t> targets, const std::function<void(Mesh)>& take) {
    using Policies = sms::GarlandHeckbert_plane_policies<Mesh, Kernel>;
    using Placement = sms::Bounded_normal_change_placement<Policies::Get_placement>;
    std::sort(targets.begin(), targets.end());
    const Policies policies(mesh);
    sms::edge_collapse(mesh, Sweep{&targets, &take},
                       CGAL::parameters::get_cost(policies.get_cost())
                           .get_placement(Placement(policies.get_placement())));
}

void report(Mesh mesh, const std::vector<Point>& original, const CGAL::Bbox_3& box) {
    const double diagonal = std::hypot(box.xmax() - box.xmin(), box.ymax() - box.ymin(),
                                       box.zmax() - box.zmin());
    mesh.collect_garbage();
    const Distances exact = distances(original, mesh);
    round_to_16_bits(mesh, box);
    const Distances rounded = distances(original, mesh);
    std::printf("{\"faces\":%zu,\"vertices\":%zu,\"rms\":%.6g,\"max\":%.6g,\"rms_16\":%.6g}\n",
                std::size_t(mesh.number_of_faces()), std::size_t(mesh.number_of_vertices()),
                exact.rms / diagonal, exact.max / diagonal, rounded.rms / diagonal);
    std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fprintf(stderr, "usage: peer_decimate MESH_OR_CLOUD.ply FACES...\n");
        return 2;
    }
    std::vector<Point> points;
    Faces faces;
    std::ifstream in(argv[1], std::ios::binary);
    CGAL::IO::read_PLY(in, points, faces);
    if (points.empty()) {
        std::fprintf(stderr, "%s: no points to read\n", argv[1]);
        return 3;
    }
    if (faces.empty()) faces = meshed(points);
    Mesh mesh = mesh_of(points, faces);
    const std::vector<Point> original = vertices_of(mesh);
    const CGAL::Bbox_3 box = CGAL::bbox_3(original.begin(), original.end());

    std::vector<std::size_t> targets;
    for (int i = 2; i < argc; ++i) targets.push_back(std::strtoul(argv[i], nullptr, 10));
    decimate(mesh, targets, [&](Mesh now) { report(std::move(now), original, box); });
    return 0;
}
