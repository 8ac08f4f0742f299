#pragma once

#include "formats/point_source.h"
#include "pipeline/build/gathered_points.h"
#include "pipeline/build/plan_file.h"
#include "slim/base/bbox.h"
#include "slim/base/reporter.h"
#include "slim/slicing/cell_counts.h"
#include "slim/slicing/far_strays.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace slim {

/// Notices that a cloud changed between two readings of it.
class InputWatch {
public:
    explicit InputWatch(std::vector<std::string> paths);
    /// throws DataError naming the file whose size or time of change is another than at the start
    void check() const;
    /// Does the work and checks, also when the work throws: what it says then is only a
    /// consequence.
    template <class Work>
    void over(Work&& work) const {
        try {
            work();
        } catch (const std::exception&) {
            check();
            throw;
        }
        check();
    }

private:
    using State = std::pair<std::uintmax_t, std::filesystem::file_time_type>;
    std::vector<std::string> paths_;
    std::vector<State> states_;
};

/// First and second moments of points about the first of them.
class Moments {
public:
    void add(const Vec3d& p);
    /// Whether all lie within a millionth of their extent of one line: such points have no surface.
    bool are_of_a_line() const;

private:
    bool has_first_ = false;
    Vec3d first_;
    double n_ = 0, x_ = 0, y_ = 0, z_ = 0, xx_ = 0, yy_ = 0, zz_ = 0, xy_ = 0, xz_ = 0, yz_ = 0;
};

/// How the points of a cloud lie: moments of all, and some thousand of them, taken evenly.
class Spread {
public:
    void add(const Vec3d& p) {
        all_.add(p);
        if ((n_++ & (step_ - 1)) == 0) keep(p);
    }
    /// Whether the points lie on one line, as Moments has it, and not only because a few strays are
    /// so far away that the others are a speck.
    bool is_line() const { return all_.are_of_a_line() && middle_is_line(); }
    /// Whether they seem to for such strays alone.
    bool has_far_strays() const { return all_.are_of_a_line() && !middle_is_line(); }

private:
    void keep(const Vec3d& p);
    bool middle_is_line() const;

    Moments all_;
    std::uint64_t n_ = 0, step_ = 1;  // a power of two
    std::vector<Vec3d> sample_;  ///< every step_-th point
};

/// What one pass over all clouds of a job finds out.
struct CloudSurvey {
    std::vector<PlanInput> inputs;
    std::vector<Bbox> boxes;    ///< of the finite points of each input, world frame
    Bbox bounds;                ///< world frame, finite points
    FarStrays::Found strays;    ///< of all inputs together
    std::uint64_t n_points = 0; ///< finite
    std::uint64_t n_dropped = 0;
    std::optional<CellCounts> cells;  ///< world frame; of points not gathered
    GatheredPoints gathered{0};  ///< all, or none if they are too many
    bool is_float32 = false;
    double coordinate_quantum = 0;  ///< largest of the inputs', of points that are no strays
    Spread spread;
    bool some_have_breadth = false;  ///< an input whose first points are of no line by themselves
};

/// Reads all clouds once. Up to most_gathered points are kept; cells are counted of more. strict: a
/// point without finite coordinates is a DataError naming it. face_points: as open_cloud has it.
/// throws what open_cloud() and read() throw; DataError if scan numbers do not fit 16 bits together
/// cost   two chunks of points in memory, and 46 bytes a gathered point
CloudSurvey survey_clouds(const std::vector<std::string>& paths, bool strict,
                          std::uint64_t most_gathered, Reporter& reporter,
                          bool face_points = false);

inline constexpr std::size_t kChunkPoints = std::size_t{1} << 16;

/// Calls take(chunk, first_id, input) for all chunks of all clouds in order, of at most
/// kChunkPoints; first_id counts all points. face_points: as open_cloud has it.
void for_each_chunk(const std::vector<std::string>& paths, Reporter& reporter,
                    const std::string& doing,
                    const std::function<void(const PointChunk&, std::uint64_t first_id,
                                             std::size_t input, const CloudInfo&)>& take,
                    bool face_points = false);

/// Step between floats at the magnitude of the coordinates as stored, 1 for integers, else 0.
double coordinate_quantum(const CloudInfo& info, const Bbox& world_bounds);

}  // namespace slim
