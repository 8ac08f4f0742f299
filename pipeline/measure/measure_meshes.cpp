#include "pipeline/measure/measure_meshes.h"

#include "formats/point_source.h"
#include "pipeline/measure/measure_points.h"
#include "pipeline/measure/mesh_input.h"
#include "pipeline/measure/number_range.h"
#include "slim/base/area_vector.h"
#include "slim/base/bbox.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

namespace slim {
namespace {

using nlohmann::json;

constexpr std::size_t kChunk = 1 << 18;

/// A mesh and where its vertices are afterwards, world frame.
struct MeshPair {
    Mesh mesh;
    std::vector<Vec3d> moved;
    double diagonal = 0;  // of the mesh as it was
};

std::vector<Vec3d> read_vertices(const std::string& path) {
    std::vector<Vec3d> out;
    const auto source = open_cloud(path);
    for (PointChunk chunk; source->read(chunk, kChunk);)
        out.insert(out.end(), chunk.position.begin(), chunk.position.end());
    return out;
}

void require_finite(const std::string& path, const std::vector<Vec3d>& vertices) {
    const auto bad = std::find_if_not(vertices.begin(), vertices.end(), is_finite<double>);
    if (bad != vertices.end())
        throw DataError(
            fmt::format("{}: vertex {}: coordinates are not finite", path, bad - vertices.begin()));
}

MeshPair read_pair(const std::string& original, const std::string& moved) {
    MeshPair out{read_mesh(original, {}), read_vertices(moved)};
    const std::size_t n = out.mesh.position.size();
    if (n != out.moved.size())
        throw DataError(fmt::format(
            "{} has {} vertices and {} has {}: {} has faces, and a mesh is compared vertex by "
            "vertex; {}to measure against a model, build one: slim build {} -o model.slim",
            original, n, moved, out.moved.size(), original,
            is_mesh(moved) ? "" : "for the distances to the nearest points add --two-way; ",
            original));
    if (n == 0) throw DataError(original + ": no vertices");
    require_finite(original, out.mesh.position), require_finite(moved, out.moved);
    Bbox box;
    for (const Vec3d& p : out.mesh.position) box.extend(p);
    out.diagonal = box.diagonal();
    for (const Vec3d& p : out.moved) box.extend(p);
    require_squares({original, moved}, box, n);
    return out;
}

/// How a face turned.
struct FaceTurn {
    double area = 0;                        // as it was
    double degrees = PointFigures::kNone;  // nan: it has no area, before or afterwards
};

std::vector<FaceTurn> turns_of(const MeshPair& pair) {
    std::vector<FaceTurn> out(pair.mesh.n_faces());
    for (std::size_t f = 0; f < out.size(); ++f) {
        const Vec3d before = area_vector(pair.mesh.position, pair.mesh.face(f));
        const Vec3d a = normalized(before),
                    b = normalized(area_vector(pair.moved, pair.mesh.face(f)));
        if (!(sq_length(a) > 0) || !(sq_length(b) > 0)) continue;
        out[f] = {length(before) / 2,
                  std::atan2(length(cross(a, b)), dot(a, b)) * 180 / std::numbers::pi};
    }
    return out;
}

json normals_turned(const std::vector<FaceTurn>& turns) {
    double sum = 0, sq = 0;
    std::uint64_t n = 0;
    for (const FaceTurn& t : turns)
        if (!std::isnan(t.degrees)) sum += t.degrees, sq += t.degrees * t.degrees, ++n;
    const double count = static_cast<double>(n);
    return {{"normal_mean_deg", n > 0 ? json(sum / count) : json()},
            {"normal_rms_deg", n > 0 ? json(std::sqrt(sq / count)) : json()},
            {"faces", turns.size()},
            {"faces_flat", turns.size() - n}};
}

/// Of every vertex how far it went, and the mean by area of how the faces about it turned.
std::vector<PointFigures> figures_of(const MeshPair& pair, const std::vector<FaceTurn>& turns,
                                     const std::vector<double>& off) {
    std::vector<PointFigures> out(off.size());
    const VertexFaces around(pair.mesh);
    for (std::size_t v = 0; v < off.size(); ++v) {
        out[v].distance = off[v];
        double sum = 0, area = 0;
        for (const std::uint32_t f : around.of(v))
            if (!std::isnan(turns[f].degrees))
                sum += turns[f].area * turns[f].degrees, area += turns[f].area;
        if (area > 0) out[v].angle = sum / area;
    }
    return out;
}

void write_figures(const std::string& path, const std::string& moved, const Mesh& faces,
                   const std::vector<PointFigures>& figures) {
    const auto source = open_cloud(moved);
    PointsFile file(
        path, source->info(),
        {false, &faces,
         "distance of each vertex from where it was, model units; angle by which the faces about "
         "it turned, degrees; nan: no face"});
    std::size_t done = 0;
    for (PointChunk chunk; source->read(chunk, kChunk); done += chunk.size())
        file.write(chunk, std::span(figures).subspan(done, chunk.size()));
    file.commit();
}

json distances_of(const MeshPair& pair, std::vector<double> off) {
    double sq = 0;
    for (const double d : off) sq += d * d;
    const auto farthest =
        static_cast<std::size_t>(std::max_element(off.begin(), off.end()) - off.begin());
    const Vec3d& at = pair.mesh.position[farthest];
    std::sort(off.begin(), off.end());
    const double diagonal = pair.diagonal, n = static_cast<double>(off.size());
    const auto over_diagonal = [&](double x) { return diagonal > 0 ? json(x / diagonal) : json(); };
    const auto percentile = [&](double share) {
        return over_diagonal(off[static_cast<std::size_t>(share * (n - 1))]);
    };
    return {{"vertices", off.size()},
            {"diagonal", diagonal},
            {"l2", over_diagonal(std::sqrt(sq / n))},
            {"max", over_diagonal(off.back())},
            {"max_at", {at.x, at.y, at.z}},
            {"p50", percentile(0.5)},
            {"p90", percentile(0.9)},
            {"p95", percentile(0.95)},
            {"p99", percentile(0.99)}};
}

}  // namespace

json compare_meshes(const std::string& original, const std::string& moved,
                    const std::string& per_point) {
    const MeshPair pair = read_pair(original, moved);
    std::vector<double> off(pair.moved.size());
    for (std::size_t i = 0; i < off.size(); ++i)
        off[i] = length(pair.moved[i] - pair.mesh.position[i]);
    const std::vector<FaceTurn> turns = turns_of(pair);
    if (!per_point.empty())
        write_figures(per_point, moved, pair.mesh, figures_of(pair, turns, off));
    json out = normals_turned(turns);
    out.update(distances_of(pair, std::move(off)));
    return out;
}

}  // namespace slim
