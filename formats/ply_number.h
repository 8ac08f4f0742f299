#pragma once

#include "formats/ply_header.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace slim {

/// Calls body(T{}) for the C++ type of a PLY type.
template <class Body>
void with_ply_type(PlyType type, const Body& body) {
    switch (type) {
        case PlyType::i8: return body(std::int8_t{});
        case PlyType::u8: return body(std::uint8_t{});
        case PlyType::i16: return body(std::int16_t{});
        case PlyType::u16: return body(std::uint16_t{});
        case PlyType::i32: return body(std::int32_t{});
        case PlyType::u32: return body(std::uint32_t{});
        case PlyType::i64: return body(std::int64_t{});
        case PlyType::u64: return body(std::uint64_t{});
        case PlyType::f32: return body(float{});
        case PlyType::f64: return body(double{});
    }
}

/// The number at `from`, which need not be aligned; swap: its bytes are the other way round.
template <class T>
T load_number(const char* from, bool swap) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, from, sizeof(T));
    if (swap) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
}

}  // namespace slim
