#include "slim/scanner/scan.h"

#include "slim/base/error.h"
#include "slim/base/parallel.h"
#include "slim/scanner/grid_normals.h"
#include "slim/scanner/noise.h"
#include "slim/scanner/range_grid.h"
#include "slim/scanner/scan_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace slim {
namespace {

constexpr double kSurplus = 1.03;                  // rays that return over points asked
constexpr std::uint64_t kBatchRays = 1'000'000;    // in memory at a time
// a pass is no coarser, however few points are asked
constexpr std::uint64_t kLeastReturns = 2'000;
constexpr int kMostIdlePasses = 20;

/// One band between casting and writing.
struct BandResult {
    RangeGrid grid;
    std::uint64_t returns = 0;
    std::uint64_t keep_below = 0;  ///< hashes up to this one are kept
    bool keep_any = false;
    ScanBlock block;
    std::uint64_t outliers = 0;
};

/// Thins the bands of a pass that only makes up for what the one before fell short of, evenly: some
/// thousand points of 100 million once took as long as all the rest. Others in every pass, by its
/// number.
void keep_some_bands(std::uint64_t n_points, std::uint64_t number, ScanPass& pass) {
    constexpr double kEnough = 4;         // times the points
    constexpr std::size_t kLeastBands = 64;  // not all of them beside the shape
    const auto wanted =
        static_cast<std::size_t>(pass.expected / (kEnough * static_cast<double>(n_points)));
    const std::size_t stride = std::min(wanted, pass.bands.size() / kLeastBands);
    if (stride < 2) return;
    std::vector<Band> some;
    for (std::size_t i = (stride / 2 + number) % stride; i < pass.bands.size(); i += stride)
        some.push_back(pass.bands[i]);
    pass.bands = std::move(some);
    pass.expected = 0;
    for (const Band& b : pass.bands) pass.expected += b.expected;
}

/// Casts, thins and writes the bands of one pass after another.
class Scanner {
public:
    Scanner(const Shape& shape, const ScanSettings& settings, const ScanSink& sink,
            Reporter& reporter)
        : shape_(shape), settings_(settings), sink_(sink), reporter_(reporter) {}

    ScanSummary run();

private:
    void run_pass(const ScanPass& pass);
    std::size_t end_of_batch(const ScanPass& pass, std::size_t begin) const;
    void run_batch(const ScanPass& pass, std::size_t begin, std::size_t end);
    void cast(const ScanPass& pass, const Band& band, BandResult& result) const;
    void choose(const Band& band, BandResult& result);
    void assemble(const ScanPass& pass, const Band& band, BandResult& result) const;
    std::uint64_t hash_of(const Band& band, const RangeGrid& grid, std::uint64_t row,
                          std::uint64_t col) const;
    template <class Body>
    void each_return(const Band& band, const RangeGrid& grid, Body&& body) const;

    const Shape& shape_;
    const ScanSettings& settings_;
    const ScanSink& sink_;
    Reporter& reporter_;
    ScanSummary summary_;
    std::uint64_t stride_ = 1;
    std::uint64_t needed_ = 0;       // points still to write
    double expected_left_ = 0;       // returns expected in this pass after the present band
    std::vector<BandResult> batch_;  // reused
};

ScanSummary Scanner::run() {
    const std::vector<Station> stations = stations_around(shape_.bounds, settings_.n_stations);
    for (const Station& s : stations) summary_.sensors.push_back(s.position);
    const ReturnEstimate estimate(shape_, settings_, stations);
    if (!(estimate.returning_area() > 0))
        throw ConfigError("scan of " + std::string(shape_.name) + ": no ray of " +
                          std::to_string(settings_.n_stations) +
                          " stations returns; more stations or less dropout are needed");
    needed_ = settings_.n_points;
    const std::uint64_t n_returns = std::max(settings_.n_points, kLeastReturns);
    const double pitch =
        std::sqrt(estimate.returning_area() / (kSurplus * static_cast<double>(n_returns)));
    summary_.sigma = settings_.noise * shape_.bounds.diagonal();
    summary_.spacing = pitch * 1.5 * shape_.bounds.diagonal();
    stride_ = normal_stride(summary_.sigma, summary_.spacing);
    int idle_passes = 0;
    for (std::uint64_t pass = 0; needed_ > 0; ++pass) {
        const std::uint64_t needed_before = needed_;
        ScanPass planned = plan_pass(estimate, stations, pitch, pass, summary_.rays);
        if (pass > 0) keep_some_bands(needed_, pass, planned);
        run_pass(planned);
        idle_passes = needed_ == needed_before ? idle_passes + 1 : 0;
        if (idle_passes > kMostIdlePasses)
            throw ConfigError("scan of " + std::string(shape_.name) + ": no ray returns");
    }
    return summary_;
}

void Scanner::run_pass(const ScanPass& pass) {
    expected_left_ = pass.expected;
    for (std::size_t begin = 0; begin < pass.bands.size() && needed_ > 0;) {
        const std::size_t end = end_of_batch(pass, begin);
        run_batch(pass, begin, end);
        begin = end;
        reporter_.progress("points", settings_.n_points - needed_, settings_.n_points);
    }
    summary_.rays += pass.rays;
}

std::size_t Scanner::end_of_batch(const ScanPass& pass, std::size_t begin) const {
    std::uint64_t rays = 0;
    std::size_t end = begin;
    while (end < pass.bands.size() && (end == begin || rays < kBatchRays)) {
        const Band& b = pass.bands[end++];
        rays += (b.end - b.begin + 2 * stride_) * pass.stations[b.station].cols;
    }
    return end;
}

void Scanner::run_batch(const ScanPass& pass, std::size_t begin, std::size_t end) {
    if (batch_.size() < end - begin) batch_.resize(end - begin);
    parallel_blocks(end - begin, 1, [&](std::size_t i, std::size_t) {
        cast(pass, pass.bands[begin + i], batch_[i]);
    });
    for (std::size_t i = begin; i < end; ++i) choose(pass.bands[i], batch_[i - begin]);
    parallel_blocks(end - begin, 1, [&](std::size_t i, std::size_t) {
        assemble(pass, pass.bands[begin + i], batch_[i]);
    });
    for (std::size_t i = 0; i < end - begin; ++i) {
        summary_.points += batch_[i].block.size();
        summary_.outliers += batch_[i].outliers;
        if (batch_[i].block.size() > 0) sink_(batch_[i].block);
    }
}

void Scanner::cast(const ScanPass& pass, const Band& band, BandResult& result) const {
    const Station& station = pass.stations[band.station];
    const std::uint64_t first = band.begin > stride_ ? band.begin - stride_ : 0;
    const std::uint64_t last = std::min(station.rows, band.end + stride_);
    cast_rows(shape_, settings_, station, band.ray_key, first, last, result.grid);
    result.returns = 0;
    each_return(band, result.grid, [&](std::uint64_t, std::uint64_t) { ++result.returns; });
}

template <class Body>
void Scanner::each_return(const Band& band, const RangeGrid& grid, Body&& body) const {
    for (std::uint64_t row = band.begin; row < band.end; ++row)
        for (std::uint64_t col = 0; col < grid.cols; ++col)
            if (grid.at(row, col).valid) body(row, col);
}

std::uint64_t Scanner::hash_of(const Band& band, const RangeGrid& grid, std::uint64_t row,
                               std::uint64_t col) const {
    return keyed_hash(settings_.seed, band.ray_key + row * grid.cols + col,
                      static_cast<std::uint64_t>(Draw::keep));
}

/// The band's part of what is still needed, in the ratio of its returns to all that are to come;
/// the returns with the least hashes are kept. Sequential over bands, so that errors of the
/// estimate are made good by the bands that follow.
void Scanner::choose(const Band& band, BandResult& result) {
    expected_left_ = std::max(0.0, expected_left_ - band.expected);
    const double returns = static_cast<double>(result.returns);
    double quota = returns;
    if (expected_left_ > 0.5)
        quota = std::min(returns, static_cast<double>(needed_) * returns /
                                      std::max(1.0, returns + expected_left_));
    const std::uint64_t n_kept =
        std::min(needed_, static_cast<std::uint64_t>(std::llround(quota)));
    needed_ -= n_kept;
    result.keep_any = n_kept > 0;
    result.keep_below = std::numeric_limits<std::uint64_t>::max();
    if (n_kept == 0 || n_kept == result.returns) return;
    std::vector<std::uint64_t> hashes;
    hashes.reserve(result.returns);
    each_return(band, result.grid, [&](std::uint64_t row, std::uint64_t col) {
        hashes.push_back(hash_of(band, result.grid, row, col));
    });
    const auto nth = hashes.begin() + static_cast<std::ptrdiff_t>(n_kept - 1);
    std::nth_element(hashes.begin(), nth, hashes.end());  // distinct: the hash is a bijection
    result.keep_below = *nth;
}

void Scanner::assemble(const ScanPass& pass, const Band& band, BandResult& result) const {
    const Station& station = pass.stations[band.station];
    result.block = {};
    result.outliers = 0;
    if (!result.keep_any) return;
    each_return(band, result.grid, [&](std::uint64_t row, std::uint64_t col) {
        if (hash_of(band, result.grid, row, col) > result.keep_below) return;
        const Return& cell = result.grid.at(row, col);
        result.block.positions.push_back(cell.position);
        result.block.normals.push_back(
            to_float(grid_normal(result.grid, station, row, col, stride_, summary_.sigma)));
        result.block.truth.push_back(cell.truth);
        result.block.scan_ids.push_back(station.id);
        result.outliers += cell.outlier;
    });
}

}  // namespace

ScanSummary scan_shape(const Shape& shape, const ScanSettings& settings, const ScanSink& sink,
                       Reporter& reporter) {
    return Scanner(shape, settings, sink, reporter).run();
}

}  // namespace slim
