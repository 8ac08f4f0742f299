#pragma once

#include "formats/cloud_rewriter.h"
#include "formats/ply_header.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace slim {

/// A number of a row that is written anew.
enum class Quantity : std::uint8_t { x, y, z, nx, ny, nz, displacement };

struct RowColumn {
    Quantity what = Quantity::x;
    PlyType type = PlyType::f32;        ///< as written: f32 or f64
    std::optional<PlyType> in_type;     ///< as read; nothing: added at the end of the row
};

/// Consecutive rows as they stand in a file, and where in them the columns stand that are written
/// anew.
struct RawRows {
    struct Slot {
        std::size_t begin = 0, end = 0;  ///< from the row's first byte
    };
    std::string_view bytes;
    std::vector<std::size_t> row_end;  ///< empty: all are of fixed_size
    std::size_t fixed_size = 0;
    std::vector<Slot>
        slots;  ///< of a row those of its read columns, in order; fixed rows: once for all

    std::string_view row(std::size_t i) const;
    const Slot* slots_of(std::size_t i, std::size_t n_columns) const;
};

/// Writes rows with some numbers replaced and some added.
class RowEncoder {
public:
    /// columns  those that are read first, in their order in the row; then those that are added
    /// origin   subtracted from positions
    RowEncoder(PlyEncoding encoding, std::vector<RowColumn> columns, const Vec3d& origin,
               double text_step);

    std::size_t n_read_columns() const { return n_read_; }
    /// The rows in pieces, to be written one behind the other; in parallel, the same for any thread
    /// count.
    std::vector<std::string> encode(const RawRows& rows,
                                    std::span<const RewrittenPoint> points) const;

private:
    void put_row(std::string_view row, const RawRows::Slot* slots, const RewrittenPoint& point,
                 std::string& out) const;
    void put_column(const RowColumn& column, std::string_view old, const RewrittenPoint& point,
                    std::string& out) const;
    double value(const RowColumn& column, const RewrittenPoint& point) const;
    void put_number(const RowColumn& column, double value, std::string_view old,
                    std::string& out) const;

    PlyEncoding encoding_;
    std::vector<RowColumn> columns_;
    std::size_t n_read_ = 0;
    Vec3d origin_;
    int decimals_ = 0;
};

}  // namespace slim
