#include "pipeline/info/info_cloud.h"

#include "formats/point_source.h"
#include "formats/truth_file.h"
#include "pipeline/contains.h"
#include "pipeline/info/info_json.h"
#include "pipeline/noise_over_diagonal.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <string_view>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kChunk = std::size_t{1} << 16;

bool finite(const Vec3d& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Totals of a cloud, gathered chunk by chunk.
struct CloudTotals {
    std::uint64_t points = 0, not_finite = 0, without_normal = 0;
    Bbox box;
    std::set<std::uint16_t> scans;

    void add(const PointChunk& chunk) {
        points += chunk.size();
        for (const Vec3d& p : chunk.position) {
            if (finite(p))
                box.extend(p);
            else
                ++not_finite;
        }
        for (const Vec3f& n : chunk.normal) {
            const float sq = dot(n, n);
            without_normal += !(sq > 0) || !std::isfinite(sq);
        }
        scans.insert(chunk.scan.begin(), chunk.scan.end());
    }
};

json cloud_json(const CloudInfo& info, const CloudTotals& totals) {
    json attributes = json::array();
    for (const std::string& name : info.carried) attributes.push_back(name);
    json out = {{"kind", "cloud"},
                {"format", info.format},
                {"bytes", info.file_size},
                {"points", totals.points},
                {"bounds", bounds_json(totals.box)},
                {"attributes", attributes},
                {"colors", info.colors.empty() ? "no" : "yes, read by slim build --color"},
                {"skipped", info.skipped},
                {"normals", info.faces_turned         ? "from faces, turned outwards"
                            : info.normals_from_faces ? "from faces"
                            : info.has_normals        ? "yes"
                                                      : "no"},
                {"truth", fs::exists(truth_path(info.path))},
                {"health", {{"not_finite", totals.not_finite}}}};
    if (info.has_normals) out["health"]["points_without_normal"] = totals.without_normal;
    if (info.has_scan) out["scans"] = totals.scans.size();
    if (info.origin) out["origin"] = vector_json(*info.origin);
    if (info.noise_variance > 0) {
        out["noise_variance"] = info.noise_variance;
        out["noise"] = noise_over_diagonal(info.noise_variance, totals.box.diagonal());
        out["about"] = "what 'slim smooth' wrote; 'slim build' makes leaves as for the noise that "
                       "it had before";
    }
    return out;
}

/// Edges that the header of a PLY declares beside its points, in place of faces; 0: none.
std::uint64_t n_edges(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::string line;
    if (!std::getline(in, line) || !line.starts_with("ply")) return 0;
    std::uint64_t edges = 0;
    while (std::getline(in, line) && !line.starts_with("end_header")) {
        if (line.starts_with("element face")) return 0;
        constexpr std::string_view kEdge = "element edge ";
        if (line.starts_with(kEdge))
            std::from_chars(line.data() + kEdge.size(), line.data() + line.size(), edges);
    }
    return edges;
}

}  // namespace

json cloud_info(const std::string& path, StageContext& context) {
    const std::unique_ptr<PointSource> source = open_cloud(path);
    CloudTotals totals;
    for (PointChunk chunk; source->read(chunk, kChunk);) {
        totals.add(chunk);
        context.reporter.progress("bytes read", source->bytes_read(), source->info().file_size);
    }
    json out = cloud_json(source->info(), totals);
    if (source->info().has_faces()) out["faces"] = source->info().n_faces;
    if (const std::uint64_t edges = n_edges(path)) {
        out["kind"] = "lines";
        out["about"] = "lines in space, as 'slim render --lines-ply' writes: points and the edges "
                       "between them";
        out["edges"] = edges;
    } else if (contains(source->info().skipped, "scalar_distance")) {
        out["about"] = "the points of a cloud with the errors of each, as 'slim measure "
                       "--per-point' writes";
    }
    return out;
}

}  // namespace slim
