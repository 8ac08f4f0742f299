#include "slim/shapes/nearest_search.h"

#include "slim/shapes/nearest_found.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace slim {
namespace {

constexpr int kMostCells = 1 << 14;
constexpr double kFarthest = 1e6;  // diagonals
// Half diagonals of cells, and distances, in diagonals of the box.
constexpr double kStartsNewton = 1.0 / 64, kResolved = 1.0 / 256, kFinest = 1e-7, kUnknown = 1e-3,
                 kKnown = 1e-5, kShare = 0.01;

struct Cell {
    Vec3d center, half;
    double nearest = 0;  ///< from x to it
    double started = 0;  ///< size of the cell that holds it in which Newton's method began; 0: none

    double size() const { return length(half); }
    bool operator<(const Cell& other) const {
        return nearest > other.nearest;
    }  // the queue's top is the nearest
};

class Search {
public:
    Search(const Shape& shape, const Vec3d& x, const Vec3d* start)
        : shape_(shape), x_(x), diagonal_(shape.bounds.diagonal()), found_(shape, x) {
        if (start && is_on(shape, *start)) found_.add(*start, false);
        push(shape.bounds.center(), shape.bounds.extent() * 0.5, 0);
    }

    std::optional<SearchedPoint> run() {
        for (int n_cells = 0; n_cells < kMostCells && !cells_.empty() && !is_settled(); ++n_cells) {
            const Cell cell = cells_.top();
            cells_.pop();
            look_into(cell);
        }
        const bool known = found_.is_stationary() || error() < kUnknown * diagonal_;
        if (!std::isfinite(found_.distance()) || !known) return std::nullopt;
        return SearchedPoint{found_.point(), found_.is_stationary()};
    }

private:
    void push(const Vec3d& center, const Vec3d& half, double started) {
        Bbox box;
        box.extend(center - half), box.extend(center + half);
        cells_.push({center, half, std::sqrt(box.sq_distance(x_)), started});
    }
    /// By how much a nearer point may be nearer.
    double error() const {
        return found_.distance() -
               std::min(left_, cells_.empty() ? found_.distance() : cells_.top().nearest);
    }
    bool is_settled() const {
        const double least = cells_.top().nearest, best = found_.distance();
        if (found_.is_stationary() || !std::isfinite(best)) return least >= best;
        return error() < std::clamp(kShare * best, kKnown * diagonal_, 0.5 * kUnknown * diagonal_);
    }
    bool is_empty(const Cell& cell) const {
        const double f = shape_.value(cell.center);
        return (f > 0 ? f : std::min(-f, shape_.band)) > shape_.lipschitz * cell.size();
    }
    void look_into(Cell cell) {
        if (is_empty(cell)) return;
        const double size = cell.size() / diagonal_;
        const bool starts =
            cell.started == 0 || (!found_.is_stationary() && size < 0.3 * cell.started);
        if (size < kStartsNewton && starts) {
            const Vec3d y = gradient_projection(shape_, cell.center);
            if (is_on(shape_, y)) found_.add_from(y);
            cell.started = size;
        }
        if (size < (found_.is_stationary() ? kResolved : kFinest))
            left_ = std::min(left_, cell.nearest);
        else
            halve(cell);
    }
    void halve(const Cell& cell) {
        const std::size_t axis = cell.half.x >= cell.half.y && cell.half.x >= cell.half.z ? 0
                                 : cell.half.y >= cell.half.z                             ? 1
                                                                                          : 2;
        Vec3d half = cell.half, off;
        half[axis] *= 0.5, off[axis] = half[axis];
        push(cell.center - off, half, cell.started);
        push(cell.center + off, half, cell.started);
    }

    const Shape& shape_;
    Vec3d x_;
    double diagonal_;
    NearestFound found_;
    std::priority_queue<Cell> cells_;
    double left_ = std::numeric_limits<double>::infinity();  ///< from x to the nearest cell that
                                                             ///< was not halved on
};

}  // namespace

std::optional<SearchedPoint> search_nearest(const Shape& shape, const Vec3d& x,
                                            const Vec3d* start) {
    const Vec3d center = shape.bounds.center(), way = x - center;
    const double most = kFarthest * shape.bounds.diagonal(), away = length(way);
    return Search(shape, away > most ? center + way * (most / away) : x, start).run();
}

}  // namespace slim
