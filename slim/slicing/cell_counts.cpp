#include "slim/slicing/cell_counts.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kSlots = 2 * CellCounts::kMostCells;  // of the hash table: half full at most
constexpr double kCellsAcross = 2048;                       // of the first box
// beyond, cell numbers are not exact in a double
constexpr double kFarthestBin = 0x1p51;
constexpr int kBits = 21;                                   // of a key, for each axis
constexpr std::int64_t kOffset = std::int64_t{1} << (kBits - 1);
constexpr double kManyPoints = 16;       // a cell's, where its number says an area
constexpr double kCellsOfPlane = 1.5;    // for each w^2

std::int64_t floor_half(std::int64_t i) { return i >= 0 ? i / 2 : (i - 1) / 2; }

double first_width(const Bbox& box) {
    double largest = 0, extent = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        largest = std::max({largest, std::abs(box.lo[axis]), std::abs(box.hi[axis])});
        extent = std::max(extent, box.hi[axis] - box.lo[axis]);
    }
    const double wanted = std::max(extent / kCellsAcross, 2 * largest / kFarthestBin);
    return wanted > 0 && std::isfinite(wanted)
               ? std::ldexp(1.0, std::clamp(std::ilogb(wanted) + 1, -1000, 1000))
               : 0x1p-1000;
}

std::size_t hash_of(std::uint64_t key) {
    key *= 0x9e3779b97f4a7c15u;
    return static_cast<std::size_t>(key ^ (key >> 32));
}

bool by_place(const Cell& a, const Cell& b) { return a.at < b.at; }

}  // namespace

CellCounts::CellCounts(const Bbox& about)
    : width_(first_width(about)), per_width_(1 / width_), slots_(kSlots) {
    const Vec3d lo = about.lo;
    base_ = {bin_of(lo.x), bin_of(lo.y), bin_of(lo.z)};
}

std::int64_t CellCounts::bin_of(double x) const {
    // Far outside only the side matters: cells merge until they reach it.
    return static_cast<std::int64_t>(
        std::clamp(std::floor(x * per_width_), -2 * kFarthestBin, 2 * kFarthestBin));
}

/// False if p lies farther from the base than a key reaches.
bool CellCounts::key_of(const Vec3d& p, std::uint64_t& key) const {
    key = 0;
    bool fits = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t at = bin_of(p[axis]) - base_[axis] + kOffset;
        fits &= at >= 0 && at < 2 * kOffset && std::abs(p[axis]) * per_width_ <= kFarthestBin;
        key = key << kBits | (static_cast<std::uint64_t>(at) & (2 * kOffset - 1));
    }
    return fits;
}

CellCounts::Slot& CellCounts::slot_of(std::uint64_t key) {
    std::size_t i = hash_of(key) % kSlots;
    while (slots_[i].n_points > 0 && slots_[i].key != key) i = (i + 1) % kSlots;
    return slots_[i];
}

void CellCounts::add(const Vec3d& p) {
    std::uint64_t key;
    if (!key_of(p, key)) coarsen_until([&](std::size_t) { return key_of(p, key); });
    Slot& slot = slot_of(key);
    slot.key = key;
    if (slot.n_points++ > 0 || ++n_used_ <= kMostCells) return;
    coarsen_until([](std::size_t n) { return n <= kMostCells; });
}

/// Merges cells, at least once, until their number will do.
template <class Done>
void CellCounts::coarsen_until(Done&& is_done) {
    std::vector<Cell> wider = cells();
    do {
        wider = merged(wider);
        width_ *= 2;
        per_width_ = 1 / width_;
        for (std::int64_t& b : base_) b = floor_half(b);
    } while (!is_done(wider.size()));
    std::fill(slots_.begin(), slots_.end(), Slot{});
    n_used_ = wider.size();
    for (const Cell& c : wider) {
        std::uint64_t key = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
            key = key << kBits | static_cast<std::uint64_t>(c.at[axis] - base_[axis] + kOffset);
        slot_of(key) = {key, c.n_points};
    }
}

std::vector<Cell> CellCounts::cells() const {
    std::vector<Cell> out;
    out.reserve(n_used_);
    for (const Slot& slot : slots_) {
        if (slot.n_points == 0) continue;
        Cell& c = out.emplace_back(Cell{{}, slot.n_points});
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto part =
                slot.key >> (kBits * (2 - static_cast<int>(axis))) & (2 * kOffset - 1);
            c.at[axis] = base_[axis] + static_cast<std::int64_t>(part) - kOffset;
        }
    }
    std::sort(out.begin(), out.end(), by_place);
    return out;
}

std::vector<Cell> merged(const std::vector<Cell>& cells) {
    std::vector<Cell> out(cells);
    for (Cell& c : out)
        for (std::int64_t& i : c.at) i = floor_half(i);
    std::sort(out.begin(), out.end(), by_place);
    std::size_t n = 0;
    for (const Cell& c : out) {
        if (n > 0 && out[n - 1].at == c.at)
            out[n - 1].n_points += c.n_points;
        else
            out[n++] = c;
    }
    out.resize(n);
    return out;
}

double surface_spacing(std::vector<Cell> cells, double width) {
    double n_points = 0;
    for (const Cell& c : cells) n_points += static_cast<double>(c.n_points);
    while (cells.size() > 8 && n_points < kManyPoints * static_cast<double>(cells.size())) {
        cells = merged(cells);
        width *= 2;
    }
    if (!(n_points > 0)) return 0;
    return width * std::sqrt(static_cast<double>(cells.size()) / kCellsOfPlane / n_points);
}

}  // namespace slim
