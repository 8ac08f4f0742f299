// CGAL's normals, curvatures and smoothing of points, for the report's comparisons.
//   peer_points METHOD in.ply out.ply [k]
// METHOD: pca_normals jet_normals jet_smooth bilateral monge (jets of degree 4 for the surface, 2
// for its Monge form). Writes the points with what the method gives (x y z nx ny nz), and for monge
// `out.k` (doubles k1 k2 a point, positive where convex against the normal), and compares those
// with in.truth if it is there. One JSON object on stdout.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/read_ply_points.h>
#include <CGAL/IO/write_ply_points.h>
#include <CGAL/Monge_via_jet_fitting.h>
#include <CGAL/Orthogonal_k_neighbor_search.h>
#include <CGAL/Search_traits_3.h>
#include <CGAL/bilateral_smooth_point_set.h>
#include <CGAL/jet_estimate_normals.h>
#include <CGAL/jet_smooth_point_set.h>
#include <CGAL/pca_estimate_normals.h>
#include <CGAL/property_map.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Vector = Kernel::Vector_3;
using Oriented = std::pair<Point, Vector>;
using Points = std::vector<Oriented>;
using PointMap = CGAL::First_of_pair_property_map<Oriented>;
using NormalMap = CGAL::Second_of_pair_property_map<Oriented>;
using Tag = CGAL::Parallel_if_available_tag;

auto with_normals() { return CGAL::parameters::point_map(PointMap()).normal_map(NormalMap()); }

/// Estimated normals have no sign of their own: they take that of the input's.
void orient_as(const Points& like, Points& points) {
    for (std::size_t i = 0; i < points.size(); ++i)
        if (points[i].second * like[i].second < 0) points[i].second = -points[i].second;
}

struct Curvatures {
    double k1, k2;
};

std::vector<Curvatures> monge(Points& points, unsigned k) {
    using Traits = CGAL::Search_traits_3<Kernel>;
    using Search = CGAL::Orthogonal_k_neighbor_search<Traits>;
    Search::Tree tree;
    for (const Oriented& p : points) tree.insert(p.first);
    tree.build();
    std::vector<Curvatures> out(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::vector<Point> near{points[i].first};
        for (const auto& found : Search(tree, points[i].first, k))
            if (found.first != points[i].first) near.push_back(found.first);
        CGAL::Monge_via_jet_fitting<Kernel> fit;
        auto form = fit(near.begin(), near.end(), 4, 2);
        form.comply_wrt_given_normal(points[i].second);
        points[i].second = form.normal_direction();
        // The form's height falls away from the normal where the surface is convex.
        out[i] = {-form.principal_curvatures(1), -form.principal_curvatures(0)};
        if (out[i].k1 < out[i].k2) std::swap(out[i].k1, out[i].k2);
    }
    return out;
}

std::string errors_of(const std::vector<Curvatures>& found, const std::string& cloud) {
    std::ifstream in(cloud.substr(0, cloud.rfind('.')) + ".truth", std::ios::binary);
    std::vector<double> truth(5 * found.size());
    if (!in.read(reinterpret_cast<char*>(truth.data()),
                 std::streamsize(truth.size() * sizeof(double))))
        return "";
    double k1 = 0, k2 = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        k1 += std::pow(found[i].k1 - truth[5 * i + 3], 2);
        k2 += std::pow(found[i].k2 - truth[5 * i + 4], 2);
    }
    const double n = double(found.size());
    return ", \"k1_rms\": " + std::to_string(std::sqrt(k1 / n)) +
           ", \"k2_rms\": " + std::to_string(std::sqrt(k2 / n));
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 4) {
        std::fprintf(stderr, "usage: peer_points METHOD in.ply out.ply [k]\n");
        return 2;
    }
    const std::string method = argv[1], in_path = argv[2], out_path = argv[3];
    const unsigned k = argc > 4 ? unsigned(std::stoul(argv[4])) : 24;
    Points points;
    std::ifstream in(in_path, std::ios::binary);
    if (!in || !CGAL::IO::read_PLY(in, std::back_inserter(points), with_normals())) {
        std::fprintf(stderr, "%s: cannot be read\n", in_path.c_str());
        return 3;
    }
    const Points input = points;
    std::vector<Curvatures> curvatures;
    const auto start = std::chrono::steady_clock::now();
    if (method == "pca_normals")
        CGAL::pca_estimate_normals<Tag>(points, k, with_normals());
    else if (method == "jet_normals")
        CGAL::jet_estimate_normals<Tag>(points, k, with_normals());
    else if (method == "jet_smooth")
        CGAL::jet_smooth_point_set<Tag>(points, k, CGAL::parameters::point_map(PointMap()));
    else if (method == "bilateral")
        CGAL::bilateral_smooth_point_set<Tag>(points, k, with_normals());
    else if (method == "monge")
        curvatures = monge(points, k);
    else
        return std::fprintf(stderr, "unknown method %s\n", method.c_str()), 2;
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    orient_as(input, points);
    std::ofstream out(out_path, std::ios::binary);
    CGAL::IO::set_binary_mode(out);
    if (!CGAL::IO::write_PLY(out, points, with_normals())) return 4;
    std::printf("{\"method\": \"%s\", \"points\": %zu, \"method_seconds\": %.6f%s}\n",
                method.c_str(), points.size(), seconds.count(),
                errors_of(curvatures, in_path).c_str());
    return 0;
}
