#pragma once

#include "formats/byte_reader.h"
#include "slim/base/vec.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace slim {

enum class PlyType : std::uint8_t { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64 };
enum class PlyEncoding { ascii, little_endian, big_endian };

constexpr std::size_t size_of(PlyType type) {
    constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    return kSizes[static_cast<std::size_t>(type)];
}
constexpr bool is_integer(PlyType type) { return type < PlyType::f32; }

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::f32;
    bool is_list = false;
    PlyType count_type = PlyType::u8;  ///< of a list only
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;

    /// Index of a property, or -1.
    int find(const std::string& property) const;
    /// Bytes of a binary row; nothing if it has a list.
    std::optional<std::size_t> fixed_size() const;
    /// Least bytes a row can take: what a count may be checked against.
    std::size_t least_row_size(PlyEncoding encoding) const;
};

struct PlyHeader {
    PlyEncoding encoding = PlyEncoding::ascii;
    std::vector<PlyElement> elements;
    std::vector<std::string> comments;
    std::optional<Vec3d> origin;  ///< of `comment slim origin X Y Z`
    double noise_variance = 0;    ///< of `comment slim noise_variance V`

    const PlyElement* find(const std::string& name) const;
};

/// Reads a header and leaves the reader at the first byte of the data. Takes tabs, leading blanks,
/// CR LF, obj_info, and both spellings of the types.
/// throws FormatError naming the line
PlyHeader read_ply_header(ByteReader& in);

}  // namespace slim
