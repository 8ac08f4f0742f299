#include "formats/fit_file.h"

#include "formats/chunk_file.h"
#include "formats/message.h"
#include "slim/base/error.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr ChunkFileKind kFitKind{"SLIMFITS", "SLIM fit", 1};

/// A fitted surfel with no gaps between its members, so that equal surfels are equal bytes.
struct Record {
    double center[3];
    double support_radius;
    double axes[9];  ///< u, v, normal
    double coefficients[kMaxCoefficients];
    double fit_error;
    std::uint64_t point_id;
    std::uint32_t n_points;
    std::uint8_t degree, level, flags, reserved;
};
static_assert(sizeof(Record) == 8 * (3 + 1 + 9 + kMaxCoefficients + 2) + 8);

void put(const Vec3d& v, double* out) { out[0] = v.x, out[1] = v.y, out[2] = v.z; }
Vec3d take(const double* v) { return {v[0], v[1], v[2]}; }

Record pack(const FittedSurfel& f) {
    Record r{};
    put(f.surfel.center, r.center);
    r.support_radius = f.surfel.support_radius;
    put(f.surfel.frame.u_axis, r.axes);
    put(f.surfel.frame.v_axis, r.axes + 3);
    put(f.surfel.frame.normal, r.axes + 6);
    std::copy(f.surfel.polynomial.a.begin(), f.surfel.polynomial.a.end(), r.coefficients);
    r.fit_error = f.fit_error;
    r.point_id = f.point_id;
    r.n_points = f.n_points;
    r.degree = static_cast<std::uint8_t>(f.surfel.degree);
    r.level = f.level;
    r.flags = f.flags;
    return r;
}

FittedSurfel unpack(const Record& r) {
    FittedSurfel f{{take(r.center),
                    r.support_radius,
                    {take(r.axes), take(r.axes + 3), take(r.axes + 6)},
                    {},
                    r.degree}};
    std::copy(r.coefficients, r.coefficients + kMaxCoefficients, f.surfel.polynomial.a.begin());
    f.fit_error = r.fit_error;
    f.n_points = r.n_points;
    f.level = r.level;
    f.flags = r.flags;
    f.point_id = r.point_id;
    return f;
}

bool is_sound(const Record& r) {
    return is_finite(take(r.center)) && std::isfinite(r.support_radius) && r.support_radius > 0 &&
           r.degree <= kMaxDegree;
}

}  // namespace

void write_fit(const std::string& path, std::span<const FittedSurfel> surfels,
               const std::string& header_json) {
    std::vector<Record> records(surfels.size());
    std::transform(surfels.begin(), surfels.end(), records.begin(), pack);
    ChunkWriter writer(path, kFitKind);
    writer.add("header_json", std::span<const char>(header_json));
    writer.add("surfels", std::span<const Record>(records));
    writer.commit();
}

FitFile read_fit(const std::string& path) {
    const ChunkFile file = ChunkFile::open(path, kFitKind);
    file.verify_all();
    const auto json = file.array<char>("header_json");
    const auto records = file.array<Record>("surfels");
    FitFile fit{{json.begin(), json.end()}, {}};
    fit.surfels.reserve(records.size());
    for (std::size_t i = 0; i < records.size(); ++i) {
        if (!is_sound(records[i]))
            throw FormatError(message(path, ": byte ", file.offset("surfels") + i * sizeof(Record),
                                      ": surfel ", i, " has no finite ball or degree ",
                                      int{records[i].degree}));
        fit.surfels.push_back(unpack(records[i]));
    }
    return fit;
}

}  // namespace slim
