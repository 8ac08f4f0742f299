#include "formats/fit_file.h"

#include "formats/chunk_file.h"
#include "formats/message.h"
#include "slim/base/error.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

/// Version 2 has further sheets of sharp surfels, version 3 points that were dropped, version 4
/// rims, version 5 second rims, version 6 corners of more than three sheets; a file without any is
/// still version 1.
constexpr ChunkFileKind kSmoothFitKind{"SLIMFITS", "SLIM fit", 1};
constexpr ChunkFileKind kSharpFitKind{"SLIMFITS", "SLIM fit", 2};
constexpr ChunkFileKind kDroppedFitKind{"SLIMFITS", "SLIM fit", 3};
constexpr ChunkFileKind kRimsFitKind{"SLIMFITS", "SLIM fit", 4};
constexpr ChunkFileKind kTwoRimsFitKind{"SLIMFITS", "SLIM fit", 5};
constexpr ChunkFileKind kFitKind{"SLIMFITS", "SLIM fit", 6};

constexpr std::size_t kWrittenAtOnce = 4096;  // records: 1 MiB

/// A fitted surfel with no gaps between its members, so that equal surfels are equal bytes.
struct Record {
    double center[3];
    double support_radius;
    double axes[9];  ///< u, v, normal
    double coefficients[kMaxCoefficients];
    double fit_error;
    std::uint64_t point_id;
    std::uint32_t n_points;
    std::uint8_t degree;  ///< and above its two bits the direction of the rim
    std::uint8_t level, flags;
    /// further sheets, + 4 if the outer join is min, + 8 if the inner one is, + 16 reach of the rim
    /// or, of sharp ones, + 16 for each sheet beyond the third further one
    std::uint8_t sharp;

    int degree_bits() const { return degree & 3; }
    std::size_t n_extra() const {
        const std::size_t few = sharp & 3u;
        return few < 3 ? few : few + (sharp >> 4 & 7u);
    }
    PackedRim rim() const {
        if (n_extra() > 2) return static_cast<PackedRim>((degree >> 2 & 31) << 3);
        return static_cast<PackedRim>((degree >> 2 & 31) << 3 | (sharp >> 4 & 7));
    }
};
static_assert(sizeof(Record) == 8 * (3 + 1 + 9 + kMaxCoefficients + 2) + 8);

/// A further sheet; those of the sharp surfels stand one after another.
struct SheetRecord {
    double axes[9];
    double coefficients[kMaxCoefficients];
};

void put(const Vec3d& v, double* out) { out[0] = v.x, out[1] = v.y, out[2] = v.z; }
Vec3d take(const double* v) { return {v[0], v[1], v[2]}; }

void put(const Frame<double>& frame, double* out) {
    put(frame.u_axis, out);
    put(frame.v_axis, out + 3);
    put(frame.normal, out + 6);
}
Frame<double> take_frame(const double* v) { return {take(v), take(v + 3), take(v + 6)}; }

std::uint8_t pack_joins(const SharpSheets& s) {
    const std::size_t few = std::min<std::size_t>(s.n_extra, 3), more = s.n_extra - few;
    return static_cast<std::uint8_t>(few + (s.outer == Join::min ? 4u : 0u) +
                                     (s.inner == Join::min ? 8u : 0u) + 16 * more);
}

Record pack(const FittedSurfel& f) {
    Record r{};
    put(f.surfel.center, r.center);
    r.support_radius = f.surfel.support_radius;
    put(f.surfel.frame, r.axes);
    std::copy(f.surfel.polynomial.a.begin(), f.surfel.polynomial.a.end(), r.coefficients);
    r.fit_error = f.fit_error;
    r.point_id = f.point_id;
    r.n_points = f.n_points;
    r.degree = static_cast<std::uint8_t>(f.surfel.degree | (f.surfel.rims.first >> 3) << 2);
    r.level = f.level;
    r.flags = f.flags;
    if (f.surfel.sharp) r.sharp = pack_joins(*f.surfel.sharp);
    r.sharp = static_cast<std::uint8_t>(r.sharp | (f.surfel.rims.first & 7) << 4);
    return r;
}

void pack_sheets(const SharpSheets& sharp, std::vector<SheetRecord>& out) {
    for (std::size_t k = 0; k < sharp.n_extra; ++k) {
        const Sheet& s = sharp.extra[k];
        SheetRecord& r = out.emplace_back();
        put(s.frame, r.axes);
        std::copy(s.polynomial.a.begin(), s.polynomial.a.end(), r.coefficients);
    }
}

std::shared_ptr<const SharpSheets> unpack_sheets(std::uint8_t joins,
                                                 std::span<const SheetRecord> records) {
    auto out = std::make_shared<SharpSheets>();
    out->n_extra = records.size();
    out->outer = joins & 4 ? Join::min : Join::max;
    out->inner = joins & 8 ? Join::min : Join::max;
    // The bound of the array is said twice: g++ 12 does not see that there are no more records.
    for (std::size_t k = 0; k < std::min(records.size(), out->extra.size()); ++k) {
        out->extra[k].frame = take_frame(records[k].axes);
        std::copy(records[k].coefficients, records[k].coefficients + kMaxCoefficients,
                  out->extra[k].polynomial.a.begin());
    }
    return out;
}

FittedSurfel unpack(const Record& r) {
    FittedSurfel f{{take(r.center),
                    r.support_radius,
                    take_frame(r.axes),
                    {},
                    r.degree_bits()}};
    f.surfel.rims.first = r.rim();
    std::copy(r.coefficients, r.coefficients + kMaxCoefficients, f.surfel.polynomial.a.begin());
    f.fit_error = r.fit_error;
    f.n_points = r.n_points;
    f.level = r.level;
    f.flags = r.flags;
    f.point_id = r.point_id;
    return f;
}

bool all_finite(std::span<const double> values) {
    return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

bool is_sound(const Record& r) {
    return is_finite(take(r.center)) && std::isfinite(r.support_radius) && r.support_radius > 0 &&
           all_finite(r.axes) && all_finite(r.coefficients) && std::isfinite(r.fit_error) &&
           r.fit_error >= 0 && r.level < 64 && r.degree < 128 && r.sharp < 128 &&
           r.n_extra() < kMostSheets && (r.n_extra() == 0 || r.rim() == 0);
}

bool is_sound(const SheetRecord& r) { return all_finite(r.axes) && all_finite(r.coefficients); }

/// One for each surfel, checked.
std::span<const PackedRim> second_rims_of(const ChunkFile& file) {
    file.verify("second_rims");
    const auto rims = file.array<PackedRim>("second_rims");
    const std::size_t n = file.array<Record>("surfels").size();
    if (rims.size() != n)
        throw FormatError(message(file.path(), ": byte ", file.offset("second_rims"), ": expected ",
                                  n, " second rims, found ", rims.size()));
    return rims;
}

}  // namespace

struct FitWriter::State {
    ChunkWriter file;
    std::size_t chunk;
    std::vector<Record> waiting;      // a call of the system for many
    std::vector<SheetRecord> sheets;  // of sharp surfels, which are few
    std::vector<PackedRim> second_rims;  // of all surfels
    bool has_rims = false, has_second_rims = false, has_many_sheets = false;

    explicit State(const std::string& path)
        : file(path, kFitKind), chunk(file.open("surfels", sizeof(Record))) {
        waiting.reserve(kWrittenAtOnce);
    }
    void flush() {
        file.append(chunk, waiting.data(), waiting.size());
        waiting.clear();
    }
};

FitWriter::FitWriter(const std::string& path) : state_(std::make_unique<State>(path)) {}
FitWriter::~FitWriter() = default;

void FitWriter::add(const FittedSurfel& surfel) {
    state_->waiting.push_back(pack(surfel));
    state_->second_rims.push_back(surfel.surfel.rims.second);
    state_->has_rims |= surfel.surfel.rims.any();
    state_->has_second_rims |= surfel.surfel.rims.second != 0;
    if (surfel.surfel.sharp) {
        pack_sheets(*surfel.surfel.sharp, state_->sheets);
        state_->has_many_sheets |= surfel.surfel.sharp->n_sheets() > kUsualSheets;
    }
    if (state_->waiting.size() == kWrittenAtOnce) state_->flush();
}

void FitWriter::commit(const std::string& header_json, std::span<const std::uint64_t> dropped) {
    ChunkWriter& file = state_->file;
    const std::span<const SheetRecord> sheets = state_->sheets;
    state_->flush();
    file.set_version((state_->has_many_sheets   ? kFitKind
                      : state_->has_second_rims ? kTwoRimsFitKind
                      : state_->has_rims ? kRimsFitKind
                      : !dropped.empty() ? kDroppedFitKind
                      : !sheets.empty()  ? kSharpFitKind
                                         : kSmoothFitKind)
                         .version);
    file.add("header_json", std::span<const char>(header_json));
    if (!sheets.empty()) file.add("sheets", sheets);
    if (state_->has_second_rims)
        file.add("second_rims", std::span<const PackedRim>(state_->second_rims));
    if (!dropped.empty()) file.add("dropped", dropped);
    file.commit(Outlasts::process);
}

void write_fit(const std::string& path, std::span<const FittedSurfel> surfels,
               const std::string& header_json, std::span<const std::uint64_t> dropped) {
    FitWriter writer(path);
    for (const FittedSurfel& s : surfels) writer.add(s);
    writer.commit(header_json, dropped);
}

FitReader::FitReader(const std::string& path) : file_(ChunkFile::open(path, kFitKind)) {
    file_.for_pieces<char>("header_json", [&](std::size_t, std::span<const char> piece) {
        header_json_.append(piece.begin(), piece.end());
    });
    if (!file_.has("sheets")) return;
    file_.verify("sheets");
    const auto sheets = file_.array<SheetRecord>("sheets");
    const auto bad = std::find_if_not(sheets.begin(), sheets.end(),
                                      [](const SheetRecord& r) { return is_sound(r); });
    if (bad == sheets.end()) return;
    const auto k = static_cast<std::size_t>(bad - sheets.begin());
    throw FormatError(message(path, ": byte ", file_.offset("sheets") + k * sizeof(SheetRecord),
                              ": sheet ", k, " is not finite"));
}

std::size_t FitReader::n_surfels() const { return file_.array<Record>("surfels").size(); }

void FitReader::for_each(const std::function<void(FittedSurfel&&)>& visit) const {
    std::span<const SheetRecord> sheets;
    if (file_.has("sheets")) sheets = file_.array<SheetRecord>("sheets");
    std::span<const PackedRim> second_rims;
    if (file_.has("second_rims")) second_rims = second_rims_of(file_);
    const auto take_record = [&](std::size_t i, const Record& r) {
        if (!is_sound(r))
            throw FormatError(
                message(file_.path(), ": byte ", file_.offset("surfels") + i * sizeof(Record),
                        ": surfel ", i, " has no finite ball, shape or error, or level ",
                        int{r.level}, " or degree ", int{r.degree}, " or sheets ", int{r.sharp}));
        FittedSurfel surfel = unpack(r);
        if (!second_rims.empty()) surfel.surfel.rims.second = second_rims[i];
        if (surfel.surfel.rims.second != 0 && !surfel.surfel.rims.any())
            throw FormatError(message(file_.path(), ": byte ", file_.offset("second_rims") + i,
                                      ": surfel ", i, " has a second rim and no first"));
        const std::size_t extra = r.n_extra();
        if (extra > sheets.size())
            throw FormatError(message(file_.path(), ": surfel ", i, " needs ", extra,
                                      " further sheets, found ", sheets.size()));
        if (extra > 0) surfel.surfel.sharp = unpack_sheets(r.sharp, sheets.first(extra));
        sheets = sheets.subspan(extra);
        visit(std::move(surfel));
    };
    file_.for_pieces<Record>("surfels", [&](std::size_t first, std::span<const Record> piece) {
        for (std::size_t i = 0; i < piece.size(); ++i) take_record(first + i, piece[i]);
    });
    if (!sheets.empty())
        throw FormatError(
            message(file_.path(), ": ", sheets.size(), " sheets belong to no surfel"));
}

std::vector<std::uint64_t> FitReader::dropped() const {
    std::vector<std::uint64_t> ids;
    if (!file_.has("dropped")) return ids;
    ids.reserve(file_.array<std::uint64_t>("dropped").size());
    file_.for_pieces<std::uint64_t>("dropped", [&](std::size_t, auto piece) {
        ids.insert(ids.end(), piece.begin(), piece.end());
    });
    return ids;
}

FitFile read_fit(const std::string& path,
                 const std::function<bool(const FittedSurfel&)>& is_wanted) {
    const FitReader reader(path);
    FitFile fit;
    if (!is_wanted) fit.surfels.reserve(reader.n_surfels());
    reader.for_each([&](FittedSurfel&& s) {
        if (!is_wanted || is_wanted(s)) fit.surfels.push_back(std::move(s));
    });
    fit.header_json = reader.header_json();
    fit.dropped = reader.dropped();
    return fit;
}

}  // namespace slim
