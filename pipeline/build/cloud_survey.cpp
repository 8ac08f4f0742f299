#include "pipeline/build/cloud_survey.h"

#include "slim/base/common_box.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <limits>

namespace slim {
namespace {

constexpr std::size_t kSampled = 4096;  // points that tell strays from the others, at most

/// Progress in bytes over all files: the only measure that every format knows.
class ByteProgress {
public:
    ByteProgress(const std::vector<std::string>& paths, std::string doing, Reporter& reporter)
        : reporter_(reporter), doing_(std::move(doing)) {
        for (const std::string& path : paths) {
            std::error_code ignored;
            const auto size = std::filesystem::file_size(path, ignored);
            total_ += ignored ? 0 : size;
        }
    }
    void show(std::uint64_t in_file) { reporter_.progress(doing_, done_ + in_file, total_); }
    void finish_file(std::uint64_t size) { done_ += size; }

private:
    Reporter& reporter_;
    std::string doing_;
    std::uint64_t done_ = 0;
    std::uint64_t total_ = 0;
};

/// Takes the chunks of one input after another into a survey.
class Surveyor {
public:
    Surveyor(CloudSurvey& survey, const std::vector<std::string>& paths, bool strict,
             std::uint64_t most_gathered)
        : survey_(survey),
          paths_(paths),
          strict_(strict),
          most_gathered_(most_gathered),
          is_gathering_(most_gathered > 0) {
        survey_.gathered = GatheredPoints(most_gathered);
    }

    void take(const PointChunk& chunk, std::uint64_t first_id, std::size_t i,
              const CloudInfo& info) {
        while (survey_.inputs.size() <= i) begin_input(first_id, info);
        PlanInput& input = survey_.inputs[i];
        if (is_gathering_ && input.first_id + info.n_points.value_or(0) > most_gathered_)
            stop_gathering();
        if (first_box_.empty()) first_box_ = box_of(chunk.position);
        Bbox box;
        run_both(
            [&] { box = take_positions(chunk, input); },
            [&] {
                if (is_gathering_ && !survey_.gathered.add(chunk, first_id, input.first_scan, info))
                    stop_gathering();
                if (!is_gathering_) count_cells(chunk.position);
            });
        if (survey_.boxes[i].empty()) survey_.some_have_breadth |= !are_of_a_line(chunk.position);
        survey_.boxes[i].extend(box);
        for (const Vec3f& n : chunk.normal) input.n_bad_normals += is_finite(n) ? 0 : 1;
        for (const std::uint16_t s : chunk.scan)
            end_scan_ = std::max(end_scan_, input.first_scan + s + 1);
        if (end_scan_ > 0x10000u)
            throw DataError(fmt::format("{}: the scans of all inputs together are more than 65536",
                                        input.path));
    }

    void finish() {
        survey_.strays = strays_.find(survey_.n_points);
        for (std::size_t i = 0; i < infos_.size(); ++i) {
            // The strays' own steps say nothing of the others'.
            const Bbox counts = survey_.strays.n > 0
                                    ? common(survey_.boxes[i], survey_.strays.box)
                                    : survey_.boxes[i];
            survey_.coordinate_quantum =
                std::max(survey_.coordinate_quantum, coordinate_quantum(infos_[i], counts));
        }
    }

private:
    void begin_input(std::uint64_t first_id, const CloudInfo& info) {
        PlanInput input;
        input.path = paths_[survey_.inputs.size()];
        input.format = info.format;
        input.has_normals = info.has_normals;
        input.normals_from_faces = info.normals_from_faces;
        input.faces_turned = info.faces_turned;
        input.n_face_points = info.n_face_points;
        input.face_points_from_size = info.face_points_from_size;
        input.has_scan = info.has_scan;
        input.first_id = first_id;
        input.first_scan = end_scan_;
        // A cloud that does not say is one scan, so that its numbers stay apart from the others'.
        if (!info.has_scan) ++end_scan_;
        survey_.is_float32 |= info.coordinates == CoordinateType::float32;
        survey_.inputs.push_back(input);
        survey_.boxes.emplace_back();
        infos_.push_back(info);
    }

    /// What was gathered is counted; a cloud that says that it is too large is not gathered first.
    /// It says how many points it has, those that are not finite among them: one that would fit
    /// without these is not gathered either.
    void stop_gathering() {
        is_gathering_ = false;
        count_cells(survey_.gathered.release(false, false).position);
    }

    static bool are_of_a_line(const std::vector<Vec3d>& positions) {
        Moments moments;
        for (const Vec3d& p : positions)
            if (is_finite(p)) moments.add(p);
        return moments.are_of_a_line();
    }

    static Bbox box_of(const std::vector<Vec3d>& positions) {
        Bbox box;
        for (const Vec3d& p : positions)
            if (is_finite(p)) box.extend(p);
        return box;
    }

    Bbox take_positions(const PointChunk& chunk, PlanInput& input) {
        Bbox box;
        for (const Vec3d& p : chunk.position) {
            ++input.n_points;
            if (is_finite(p)) {
                box.extend(p);
                survey_.spread.add(p);
                strays_.add(p);
                ++survey_.n_points;
                continue;
            }
            if (strict_)
                throw DataError(fmt::format("{}: point {}: coordinates are not finite", input.path,
                                            input.n_points));
            ++input.n_dropped;
            ++survey_.n_dropped;
        }
        survey_.bounds.extend(box);
        return box;
    }

    void count_cells(const std::vector<Vec3d>& positions) {
        if (first_box_.empty()) return;
        if (!survey_.cells) survey_.cells.emplace(first_box_);
        for (const Vec3d& p : positions)
            if (is_finite(p)) survey_.cells->add(p);
    }

    CloudSurvey& survey_;
    FarStrays strays_;
    const std::vector<std::string>& paths_;
    bool strict_;
    std::uint64_t most_gathered_;
    bool is_gathering_;
    Bbox first_box_;  // of the first chunk with finite points: cells start from it
    std::uint32_t end_scan_ = 0;
    std::vector<CloudInfo> infos_;  // of the inputs
};

/// A file that is not there has no size; the reader says so.
std::pair<std::uintmax_t, std::filesystem::file_time_type> state_of(const std::string& path) {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    return {size, std::filesystem::last_write_time(path, error)};
}

}  // namespace

void Moments::add(const Vec3d& p) {
    if (!has_first_) first_ = p, has_first_ = true;
    const Vec3d d = p - first_;
    n_ += 1, x_ += d.x, y_ += d.y, z_ += d.z;
    xx_ += d.x * d.x, yy_ += d.y * d.y, zz_ += d.z * d.z;
    xy_ += d.x * d.y, xz_ += d.x * d.z, yz_ += d.y * d.z;
}

bool Moments::are_of_a_line() const {
    const auto moment = [&](double ab, double a, double b) { return ab / n_ - a / n_ * (b / n_); };
    const double xx = moment(xx_, x_, x_), yy = moment(yy_, y_, y_), zz = moment(zz_, z_, z_);
    const double xy = moment(xy_, x_, y_), xz = moment(xz_, x_, z_), yz = moment(yz_, y_, z_);
    // Of the eigenvalues the sum, and the sum of the products of two: about the middle one over the
    // largest.
    const double sum = xx + yy + zz;
    const double pairs = xx * yy + yy * zz + zz * xx - xy * xy - xz * xz - yz * yz;
    return sum > 0 && pairs < 1e-12 * sum * sum;
}

void Spread::keep(const Vec3d& p) {
    sample_.push_back(p);
    if (sample_.size() < kSampled) return;
    for (std::size_t i = 0; 2 * i < sample_.size(); ++i) sample_[i] = sample_[2 * i];
    sample_.resize(sample_.size() / 2);
    step_ *= 2;
}

/// The sample without the tenth that is farthest from its middle; of few points strays may be more
/// than that.
bool Spread::middle_is_line() const {
    Vec3d middle;
    std::vector<double> values(sample_.size());
    const auto nth = [&](double share) {
        const auto at = values.begin() +
                        static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
        std::nth_element(values.begin(), at, values.end());
        return *at;
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = sample_[i][axis];
        middle[axis] = nth(0.5);
    }
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = length(sample_[i] - middle);
    const double most = nth(0.9);
    Moments near;
    for (const Vec3d& p : sample_)
        if (length(p - middle) <= most) near.add(p);
    return near.are_of_a_line();
}

InputWatch::InputWatch(std::vector<std::string> paths) : paths_(std::move(paths)) {
    for (const std::string& path : paths_) states_.push_back(state_of(path));
}

void InputWatch::check() const {
    for (std::size_t i = 0; i < paths_.size(); ++i)
        if (state_of(paths_[i]) != states_[i])
            throw DataError(paths_[i] +
                            ": changed while it was read; run the command again when it is "
                            "complete");
}

double coordinate_quantum(const CloudInfo& info, const Bbox& world_bounds) {
    if (world_bounds.empty()) return 0;
    if (info.coordinates == CoordinateType::integer) return 1;
    if (info.coordinates != CoordinateType::float32) return 0;
    const Vec3d shift = info.origin.value_or(Vec3d{});
    double largest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        largest = std::max({largest, std::abs(world_bounds.lo[axis] - shift[axis]),
                            std::abs(world_bounds.hi[axis] - shift[axis])});
    return largest > 0 ? std::ldexp(1.0, std::ilogb(largest) - 23) : 0;
}

void for_each_chunk(const std::vector<std::string>& paths, Reporter& reporter,
                    const std::string& doing,
                    const std::function<void(const PointChunk&, std::uint64_t, std::size_t,
                                             const CloudInfo&)>& take,
                    bool face_points) {
    ByteProgress progress(paths, doing, reporter);
    PointChunk chunk, next;
    std::uint64_t first_id = 0;
    for (std::size_t i = 0; i < paths.size(); ++i) {
        const auto source = open_cloud(paths[i], face_points);
        bool more = source->read(chunk, kChunkPoints), after = false;
        while (true) {
            // The next chunk is read while this one is taken; what is wrong here comes first.
            std::exception_ptr unreadable;
            const auto read_next = [&] {
                try {
                    after = more && source->read(next, kChunkPoints);
                } catch (...) {
                    unreadable = std::current_exception();
                }
            };
            run_both(read_next, [&] { take(chunk, first_id, i, source->info()); });
            if (unreadable) std::rethrow_exception(unreadable);
            if (!more) break;
            first_id += chunk.size();
            progress.show(source->bytes_read());
            std::swap(chunk, next);
            more = after;
        }
        progress.finish_file(source->info().file_size);
    }
}

CloudSurvey survey_clouds(const std::vector<std::string>& paths, bool strict,
                          std::uint64_t most_gathered, Reporter& reporter, bool face_points) {
    CloudSurvey survey;
    Surveyor surveyor(survey, paths, strict, most_gathered);
    for_each_chunk(paths, reporter, "reading",
                   [&](const PointChunk& chunk, std::uint64_t first_id, std::size_t i,
                       const CloudInfo& info) { surveyor.take(chunk, first_id, i, info); },
                   face_points);
    surveyor.finish();
    return survey;
}

}  // namespace slim
