#include "pipeline/measure/measure_cloud.h"

#include "formats/point_source.h"
#include "formats/truth_file.h"
#include "pipeline/measure/measure_faces.h"
#include "pipeline/measure/measure_points.h"
#include "pipeline/measure/mesh_input.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

namespace slim {
namespace {

using nlohmann::json;

constexpr std::size_t kChunk = 1 << 18;
constexpr std::size_t kGrain = 2048;

/// Sums over points; those of a block are added in order, so threads do not matter.
struct Sums {
    std::uint64_t points = 0, missed = 0, opposed = 0, astray = 0, no_normal = 0, within = 0;
    double sq_distance = 0, max = -1 /* none yet */, sq_angle = 0, sq_k1 = 0, sq_k2 = 0,
           sq_mean = 0;
    std::uint64_t n_angles = 0, n_curvatures = 0;
    Vec3d max_at;  // world; the first point of the greatest distance
    Bbox box;      // world, of all finite points

    void add_distance(double t, const Vec3d& world, double tolerance) {
        sq_distance += t * t;
        within += std::abs(t) <= tolerance ? 1 : 0;
        if (std::abs(t) > max) max = std::abs(t), max_at = world;
    }
    void add(const Sums& b) {
        points += b.points, missed += b.missed, opposed += b.opposed, astray += b.astray;
        no_normal += b.no_normal, within += b.within;
        sq_distance += b.sq_distance;
        if (b.max > max) max = b.max, max_at = b.max_at;
        sq_angle += b.sq_angle, n_angles += b.n_angles;
        n_curvatures += b.n_curvatures, sq_k1 += b.sq_k1, sq_k2 += b.sq_k2, sq_mean += b.sq_mean;
        box.extend(b.box);
    }
};

double angle_deg(const Vec3d& a, const Vec3d& b) {
    return std::atan2(length(cross(a, b)), dot(a, b)) * 180 / std::numbers::pi;
}

/// Points of one block against the surface.
class PointMeter {
public:
    PointMeter(const MeasuredSurface& surface, double tolerance)
        : put_(surface.new_projector()), origin_(surface.origin), tolerance_(tolerance) {}

    /// `truth` may be null.
    PointFigures measure(const Vec3d& world, const Vec3f& own_normal, const PointTruth* truth,
                         Sums& sums) {
        PointFigures out;
        if (!is_finite(world)) return out;
        ++sums.points;
        sums.box.extend(world);
        const ProjectedPoint put = put_(world - origin_, to_double(own_normal), truth != nullptr);
        sums.no_normal += put.has_normal ? 0u : 1u;
        sums.missed += put.hit ? 0u : 1u;
        if (!put.hit) return out;
        sums.opposed += put.opposed ? 1u : 0u;
        sums.astray += put.astray ? 1u : 0u;
        sums.add_distance(put.hit->t, world, tolerance_);
        out.distance = -put.hit->t;  // the line that met the surface runs outwards
        if (!(sq_length(put.hit->normal) > 0))
            return out;  // the apex of a cone has no normal, no curvature
        if (truth || put.has_normal)
            out.angle =
                add_angle(*put.hit, truth ? truth->normal : put.direction, put.opposed, sums);
        if (truth) add_curvature(put.hit->curvature, *truth, sums, out);
        return out;
    }

private:
    static double add_angle(const Projection& hit, const Vec3d& reference, bool opposed,
                            Sums& sums) {
        double angle = angle_deg(hit.normal, reference);
        if (opposed) angle = std::min(angle, 180 - angle);
        sums.sq_angle += angle * angle;
        ++sums.n_angles;
        return angle;
    }
    static void add_curvature(const Curvature& c, const PointTruth& truth, Sums& sums,
                              PointFigures& out) {
        const auto sq = [](double x) { return x * x; };
        out.k1 = c.k1 - truth.k1, out.k2 = c.k2 - truth.k2;
        out.mean = c.mean - 0.5 * (truth.k1 + truth.k2);
        ++sums.n_curvatures;
        sums.sq_k1 += sq(out.k1), sums.sq_k2 += sq(out.k2), sums.sq_mean += sq(out.mean);
    }

    PutPoint put_;
    Vec3d origin_;
    double tolerance_;
};

struct Distances {
    LogHistogram distance, angle;

    void add(const std::vector<PointFigures>& figures) {
        for (const PointFigures& f : figures) {
            if (!std::isnan(f.distance)) distance.add(std::abs(f.distance));
            if (!std::isnan(f.angle)) angle.add(f.angle);
        }
    }
};

json summary(const Sums& s, const Distances& d, const MeasuredSurface& surface, bool truth,
             double tolerance) {
    const std::uint64_t n = s.points - s.missed;
    const double diagonal = surface.diagonal, hits = static_cast<double>(n);
    json out = {{"points", s.points},
                {"missed", s.missed},
                {"opposed", s.opposed},
                {"astray", s.astray},
                {"without_normal", s.no_normal},
                {"l2", rms(s.sq_distance, hits, diagonal)},
                {"max", n > 0 ? json(s.max / diagonal) : json()},
                {"max_at", n > 0 ? json{s.max_at.x, s.max_at.y, s.max_at.z} : json()},
                {"normal_rms_deg", rms(s.sq_angle, static_cast<double>(s.n_angles))},
                {"normal_p99_deg", s.n_angles > 0 ? json(d.angle.quantile(0.99)) : json()},
                {"tolerance", tolerance},
                {"completeness", static_cast<double>(s.within) / static_cast<double>(s.points)},
                {"diagonal", diagonal}};
    put_percentiles(d.distance, diagonal, out);
    if (!truth) return out;
    for (const auto& [key, sum] : {std::pair{"k1_rms", s.sq_k1}, std::pair{"k2_rms", s.sq_k2},
                                   std::pair{"mean_curvature_rms", s.sq_mean}}) {
        out[key] = rms(sum, static_cast<double>(s.n_curvatures));
        out[std::string(key) + "_x_diagonal"] =
            rms(sum, static_cast<double>(s.n_curvatures), 1 / diagonal);
    }
    return out;
}

[[noreturn]] void refuse_all_missed(const MeasuredSurface& surface, const PlacedFile& cloud,
                                    std::uint64_t n_points) {
    if (!surface.file.path.empty()) refuse_apart(cloud, surface.file, n_points);
    throw NumericalError(fmt::format(
        "{}: no nearest point of the shape was found within ten of its diagonals for {}: is the "
        "cloud in the shape's frame and unit? --offset says where in the world the shape lies. "
        "Nothing is written",
        cloud.path,
        n_points == 1 ? "its one point" : fmt::format("any of its {} points", n_points)));
}

}  // namespace

json rms(double sum, double n, double unit) {
    return n > 0 ? json(std::sqrt(sum / n) / unit) : json();
}

void put_percentiles(const LogHistogram& distances, double diagonal, json& out) {
    for (const int percent : {50, 90, 95, 99})
        out[fmt::format("p{}", percent)] =
            distances.size() > 0 ? json(distances.quantile(percent / 100.0) / diagonal) : json();
}

json measure_cloud(const MeasuredSurface& surface, const CloudFiles& files, double tolerance,
                   StageContext& context) {
    const auto source = open_cloud(files.cloud);
    std::optional<TruthReader> truth_file;
    if (!files.truth.empty()) truth_file.emplace(files.truth);
    std::optional<PointsFile> written;
    if (!files.per_point.empty())
        written.emplace(files.per_point, source->info(), PointsFileKind{truth_file.has_value()});
    Sums sums;
    Distances distances;
    PointChunk chunk;
    std::vector<PointTruth> truth;  // of the chunk
    std::vector<PointFigures> figures;
    while (source->read(chunk, kChunk)) {
        if (truth_file) {
            truth_file->read(chunk.size(), files.cloud, truth);
            check_truth(truth, truth_file->n_points() - truth_file->n_left() - truth.size(),
                        files.truth);
        }
        std::vector<Sums> partial((chunk.size() + kGrain - 1) / kGrain);
        figures.assign(chunk.size(), {});
        parallel_blocks(chunk.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            PointMeter meter(surface, tolerance * surface.diagonal);
            for (std::size_t i = begin; i < end; ++i)
                figures[i] = meter.measure(
                    chunk.position[i], chunk.normal.empty() ? Vec3f{} : chunk.normal[i],
                    truth_file ? &truth[i] : nullptr, partial[begin / kGrain]);
        });
        for (const Sums& p : partial) sums.add(p);
        distances.add(figures);
        if (written) written->write(chunk, figures);
        context.reporter.progress("measure", source->bytes_read(), source->info().file_size);
        context.check_stop();
    }
    if (truth_file && truth_file->n_left() > 0)
        throw FormatError(fmt::format("{}: expected the truth of {} points, found {}", files.truth,
                                      truth_file->n_points() - truth_file->n_left(),
                                      truth_file->n_points()));
    if (sums.points == 0) throw DataError(files.cloud + ": no finite point to measure");
    const bool corners_only = surface.corners_may_miss && meet(sums.box, surface.file.box);
    if (sums.missed == sums.points && !corners_only)
        refuse_all_missed(surface, {files.cloud, sums.box}, sums.points);
    json faces;
    if (is_mesh(files.cloud)) try {
            faces = measure_faces(surface, files.cloud, source->info().faces_turned, tolerance,
                                  context);
        } catch (const FormatError& error) {
            context.reporter.warn(std::string(error.what()) +
                                  ": figures are of the vertices, not of the faces");
        }
    if (written) written->commit();
    json out = summary(sums, distances, surface, truth_file.has_value(), tolerance);
    if (faces.is_null()) return out;
    out["completeness"] = faces["completeness"];
    out["faces"] = std::move(faces);
    return out;
}

}  // namespace slim
