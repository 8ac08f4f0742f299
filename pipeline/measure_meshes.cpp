#include "pipeline/measure_meshes.h"

#include "formats/point_source.h"
#include "pipeline/mesh_input.h"
#include "slim/base/bbox.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

namespace slim {
namespace {

using nlohmann::json;

std::vector<Vec3d> read_vertices(const std::string& path) {
    constexpr std::size_t kChunk = 1 << 18;
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

/// Normal of a face, of no length where it has no area.
Vec3d face_normal(const std::vector<Vec3d>& p, std::span<const std::uint32_t> face) {
    Vec3d sum;
    for (std::size_t k = 2; k < face.size(); ++k)
        sum += cross(p[face[k - 1]] - p[face[0]], p[face[k]] - p[face[0]]);
    return normalized(sum);
}

json normals_turned(const Mesh& mesh, const std::vector<Vec3d>& moved) {
    double sum = 0, sq = 0;
    std::uint64_t n = 0;
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const Vec3d a = face_normal(mesh.position, mesh.face(f)),
                    b = face_normal(moved, mesh.face(f));
        if (!(sq_length(a) > 0) || !(sq_length(b) > 0)) continue;
        const double angle = std::atan2(length(cross(a, b)), dot(a, b)) * 180 / std::numbers::pi;
        sum += angle, sq += angle * angle, ++n;
    }
    const double count = static_cast<double>(n);
    return {{"normal_mean_deg", n > 0 ? json(sum / count) : json()},
            {"normal_rms_deg", n > 0 ? json(std::sqrt(sq / count)) : json()},
            {"faces", mesh.n_faces()},
            {"faces_flat", mesh.n_faces() - n}};
}

}  // namespace

json compare_meshes(const std::string& original, const std::string& moved) {
    const Mesh mesh = read_mesh(original, {});
    const std::vector<Vec3d> after = read_vertices(moved);
    const std::size_t n = mesh.position.size();
    if (n != after.size())
        throw DataError(fmt::format(
            "{} has {} vertices and {} has {}: meshes are compared vertex by vertex; to "
            "measure against a model, build one: slim build {} -o model.slim",
            original, n, moved, after.size(), original));
    if (n == 0) throw DataError(original + ": no vertices");
    require_finite(original, mesh.position), require_finite(moved, after);
    Bbox box;
    for (const Vec3d& p : mesh.position) box.extend(p);
    const double diagonal = box.diagonal();
    std::vector<double> off(n);
    double sq = 0;
    for (std::size_t i = 0; i < n; ++i)
        off[i] = length(after[i] - mesh.position[i]), sq += off[i] * off[i];
    const auto farthest =
        static_cast<std::size_t>(std::max_element(off.begin(), off.end()) - off.begin());
    const Vec3d& at = mesh.position[farthest];
    json out = normals_turned(mesh, after);
    std::sort(off.begin(), off.end());
    const auto over_diagonal = [&](double x) { return diagonal > 0 ? json(x / diagonal) : json(); };
    const auto percentile = [&](double share) {
        return over_diagonal(off[static_cast<std::size_t>(share * static_cast<double>(n - 1))]);
    };
    out.update({{"vertices", n},
                {"diagonal", diagonal},
                {"l2", over_diagonal(std::sqrt(sq / static_cast<double>(n)))},
                {"max", over_diagonal(off.back())},
                {"max_at", {at.x, at.y, at.z}},
                {"p50", percentile(0.5)},
                {"p90", percentile(0.9)},
                {"p95", percentile(0.95)},
                {"p99", percentile(0.99)}});
    return out;
}

}  // namespace slim
