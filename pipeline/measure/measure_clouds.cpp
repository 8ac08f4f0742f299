#include "pipeline/measure/measure_clouds.h"

#include "formats/point_source.h"
#include "pipeline/measure/measure_points.h"
#include "pipeline/measure/nearest_points.h"
#include "pipeline/measure/number_range.h"
#include "slim/base/bbox.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace slim {
namespace {

using nlohmann::json;

constexpr std::size_t kChunk = 1 << 18;

struct CloudExtent {
    std::uint64_t n = 0;  // points, also those not finite
    Bbox box;             // of the finite ones, world
};

CloudExtent extent_of(const std::string& path, StageContext& context) {
    CloudExtent out;
    const auto source = open_cloud(path);
    for (PointChunk chunk; source->read(chunk, kChunk);) {
        out.n += chunk.size();
        for (const Vec3d& p : chunk.position)
            if (is_finite(p)) out.box.extend(p);
        context.reporter.progress("reading", source->bytes_read(), source->info().file_size);
        context.check_stop();
    }
    if (out.box.empty()) throw DataError(path + ": no finite point to measure");
    return out;
}

/// What is said of distances, in the order of the points.
class DistanceFigures {
public:
    explicit DistanceFigures(double tolerance) : tolerance_(tolerance) {}
    void add(double distance, const Vec3d& at) {
        ++n_, sq_ += distance * distance;
        within_ += distance <= tolerance_ ? 1 : 0;
        if (distance > max_) max_ = distance, max_at_ = at;
        distances_.add(distance);
    }
    void skip() { ++not_finite_; }
    std::uint64_t n() const { return n_; }
    json to_json(double diagonal) const {
        const double n = static_cast<double>(n_);
        json out = {{"points", n_}, {"not_finite", not_finite_}};
        const bool known = n_ > 0 && diagonal > 0;
        out["l2"] = known ? rms(sq_, n, diagonal) : json();
        out["max"] = known ? json(max_ / diagonal) : json();
        out["max_at"] = n_ > 0 ? json{max_at_.x, max_at_.y, max_at_.z} : json();
        out["within"] = n_ > 0 ? json(static_cast<double>(within_) / n) : json();
        if (diagonal > 0) put_percentiles(distances_, diagonal, out);
        return out;
    }

private:
    double tolerance_;
    std::uint64_t n_ = 0, not_finite_ = 0, within_ = 0;
    double sq_ = 0, max_ = -1;
    Vec3d max_at_;
    LogHistogram distances_;
};

/// The n-th points of two clouds, chunk by chunk.
class PointByPoint {
public:
    PointByPoint(const ComparedClouds& clouds, double diagonal)
        : names_(clouds.first, clouds.second),
          figures_(clouds.tolerance * diagonal),
          diagonal_(diagonal),
          first_(open_cloud(clouds.first)),
          second_(open_cloud(clouds.second)),
          normals_(first_->info().has_normals && second_->info().has_normals) {
        if (clouds.per_point.empty()) return;
        file_.emplace(
            clouds.per_point, second_->info(),
            PointsFileKind{false, nullptr,
                           "distance of each point from its place in the first cloud, model units; "
                           "angle between the normals, degrees; nan: not known"});
    }
    /// throws DataError if there is no point that is finite in both, unless `may_be_none`
    json run(bool may_be_none, StageContext& context) {
        PointChunk a, b;
        while (first_->read(a, kChunk) && second_->read(b, kChunk)) {
            add(a, b);
            context.reporter.progress("measure", second_->bytes_read(), second_->info().file_size);
            context.check_stop();
        }
        if (figures_.n() == 0 && !may_be_none)
            throw DataError(
                fmt::format("{} and {}: no point to measure: no n-th point is finite in both; "
                            "--two-way compares them in any order",
                            names_.first, names_.second));
        if (file_) file_->commit();
        json out = figures_.to_json(diagonal_);
        const double n = static_cast<double>(n_angles_);
        if (normals_) out["normal_mean_deg"] = n_angles_ > 0 ? json(sum_angle_ / n) : json();
        if (normals_) out["normal_rms_deg"] = rms(sq_angle_, n);
        return out;
    }

private:
    void add(const PointChunk& a, const PointChunk& b) {
        SLIM_CHECK(a.size(), ==, b.size());
        per_point_.assign(b.size(), {});
        for (std::size_t i = 0; i < b.size(); ++i) {
            if (!is_finite(a.position[i]) || !is_finite(b.position[i])) {
                figures_.skip();
                continue;
            }
            per_point_[i].distance = length(b.position[i] - a.position[i]);
            figures_.add(per_point_[i].distance, a.position[i]);
            if (normals_)
                per_point_[i].angle = add_angle(to_double(a.normal[i]), to_double(b.normal[i]));
        }
        if (file_) file_->write(b, per_point_);
    }
    double add_angle(const Vec3d& a, const Vec3d& b) {
        if (!is_finite(a) || !is_finite(b) || !(sq_length(a) > 0) || !(sq_length(b) > 0))
            return PointFigures::kNone;
        const double angle = std::atan2(length(cross(a, b)), dot(a, b)) * 180 / std::numbers::pi;
        sum_angle_ += angle, sq_angle_ += angle * angle, ++n_angles_;
        return angle;
    }

    std::pair<std::string, std::string> names_;
    DistanceFigures figures_;
    double diagonal_;
    std::unique_ptr<PointSource> first_, second_;
    bool normals_;
    std::optional<PointsFile> file_;
    std::vector<PointFigures> per_point_;  // of the chunk
    double sum_angle_ = 0, sq_angle_ = 0;
    std::uint64_t n_angles_ = 0;
};

/// Distances of one cloud's points, n of them, to the nearest of another.
json to_nearest(const std::string& from, std::uint64_t n, const std::string& to, double diagonal,
                double tolerance, StageContext& context) {
    std::vector<Vec3d> places;
    places.reserve(n);
    DistanceFigures figures(tolerance * diagonal);
    const auto source = open_cloud(from);
    for (PointChunk chunk; source->read(chunk, kChunk);)
        for (const Vec3d& p : chunk.position)
            if (is_finite(p)) places.push_back(p);
            else figures.skip();
    const std::vector<double> sq =
        sq_to_points(places, to, {}, [&](std::uint64_t done, std::uint64_t total) {
            context.reporter.progress("nearest points", done, total);
            context.check_stop();
        });
    for (std::size_t i = 0; i < sq.size(); ++i) {
        figures.add(std::sqrt(sq[i]), places[i]);
    }
    return figures.to_json(diagonal);
}

[[noreturn]] void refuse_counts(const ComparedClouds& clouds, std::uint64_t first,
                                std::uint64_t second) {
    throw DataError(
        fmt::format("{} has {} points and {} has {}: clouds are compared point by point, in the "
                    "order of their files; expected as many{}. To measure against a surface, build "
                    "a model: slim build {} -o model.slim",
                    clouds.first, first, clouds.second, second,
                    clouds.two_way ? " for --per-point"
                                   : ", or --two-way for the distances to the nearest points",
                    clouds.first));
}

}  // namespace

json compare_clouds(const ComparedClouds& clouds, StageContext& context) {
    const CloudExtent first = extent_of(clouds.first, context),
                      second = extent_of(clouds.second, context);
    const bool as_many = first.n == second.n;
    if (!as_many && (!clouds.two_way || !clouds.per_point.empty()))
        refuse_counts(clouds, first.n, second.n);
    const double diagonal = first.box.diagonal();
    Bbox both = first.box;
    both.extend(second.box);
    require_squares({clouds.first, clouds.second}, both, std::max(first.n, second.n));
    json out =
        as_many ? PointByPoint(clouds, diagonal).run(clouds.two_way, context) : json::object();
    out["diagonal"] = diagonal;
    if (!clouds.two_way) return out;
    out["first_to_second"] =
        to_nearest(clouds.first, first.n, clouds.second, diagonal, clouds.tolerance, context);
    out["second_to_first"] =
        to_nearest(clouds.second, second.n, clouds.first, diagonal, clouds.tolerance, context);
    return out;
}

}  // namespace slim
