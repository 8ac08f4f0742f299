#include "pipeline/build/cloud_survey.h"

#include "pipeline/build/each_chunk.h"
#include "pipeline/file_hash.h"
#include "slim/base/common_box.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace slim {
namespace {

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
        if (chunk.size() == 0) input.n_undeclared = info.n_undeclared;  // all is read
        if (is_gathering_ && input.first_id + info.n_points.value_or(0) > most_gathered_)
            stop_gathering();
        if (first_box_.empty()) first_box_ = box_of(chunk.position);
        Bbox box;
        run_both(
            [&] { box = take_positions(chunk, input); },
            [&] {
                if (is_gathering_ && !survey_.gathered.add(chunk, first_id, input.first_scan, info))
                    stop_gathering();
                if (is_gathering_) return take_attributes(chunk, input);
                run_both([&] { count_cells(chunk.position); },
                         [&] { take_attributes(chunk, input); });
            });
        if (survey_.boxes[i].empty()) survey_.some_have_breadth |= !are_of_a_line(chunk.position);
        survey_.boxes[i].extend(box);
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
        input.noise_variance = info.noise_variance;
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
        PointMoments moments;
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
        std::uint64_t n_dropped = 0;
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            const Vec3d& p = chunk.position[i];
            if (is_finite(p)) {
                box.extend(p);
                survey_.spread.add(p);
                strays_.add(p);
                continue;
            }
            if (strict_)
                throw DataError(fmt::format("{}: point {}: coordinates are not finite", input.path,
                                            input.n_points + i + 1));
            ++n_dropped;
        }
        input.n_points += chunk.size();
        input.n_dropped += n_dropped;
        survey_.n_points += chunk.size() - n_dropped;
        survey_.n_dropped += n_dropped;
        survey_.bounds.extend(box);
        return box;
    }

    void take_attributes(const PointChunk& chunk, PlanInput& input) {
        // Counted apart from what other threads count beside it.
        std::uint64_t n_bad = 0;
        for (const Vec3f& n : chunk.normal)
            n_bad += !is_finite(n) || (n == Vec3f{} && !input.normals_from_faces) ? 1 : 0;
        if (n_bad > 0) input.n_bad_normals += n_bad;
        if (chunk.scan.empty()) return;
        const std::uint16_t last = *std::max_element(chunk.scan.begin(), chunk.scan.end());
        end_scan_ = std::max(end_scan_, input.first_scan + last + 1u);
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

}  // namespace

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

CloudSurvey survey_clouds(const std::vector<std::string>& paths, bool strict,
                          std::uint64_t most_gathered, Reporter& reporter, bool face_points) {
    CloudSurvey survey;
    Surveyor surveyor(survey, paths, strict, most_gathered);
    std::optional<FileHash> hash;
    const auto hash_up_to = [&](std::size_t i, std::uint64_t n_bytes) {
        if (hash && survey.hashes.size() < i) survey.hashes.push_back(hash->finish()), hash.reset();
        if (!hash) hash.emplace(paths[i]);
        hash->advance_to(n_bytes);
    };
    for_each_chunk(paths, reporter, "reading",
                   [&](const PointChunk& chunk, std::uint64_t first_id, std::size_t i,
                       const CloudInfo& info) { surveyor.take(chunk, first_id, i, info); },
                   face_points, hash_up_to);
    if (hash) survey.hashes.push_back(hash->finish());
    surveyor.finish();
    return survey;
}

}  // namespace slim
