#pragma once

#include <cstddef>
#include <cstdint>

namespace slim {

/// What stands at the front of every binary file of ours, and one row of its table of chunks. All
/// little-endian. The file: header, chunks (each from a multiple of 64, zeros between), table.
struct ChunkFileHeader {
    char magic[8];
    std::uint32_t version;
    std::uint32_t endian_mark;
    std::uint64_t file_size;
    std::uint64_t table_offset;
    std::uint32_t n_chunks;
    std::uint32_t reserved;
    std::uint64_t table_checksum;   ///< XXH3-64 of the table
    std::uint64_t reserved2;
    std::uint64_t header_checksum;  ///< XXH3-64 of the 56 bytes before
};
static_assert(sizeof(ChunkFileHeader) == 64);

struct ChunkEntry {
    char name[24];  ///< filled up with zeros
    std::uint32_t element_size;
    std::uint32_t reserved;
    std::uint64_t count;
    std::uint64_t offset;
    std::uint64_t checksum;  ///< XXH3-64 of the chunk's bytes
    std::uint64_t reserved2;
};
static_assert(sizeof(ChunkEntry) == 64);

inline constexpr std::uint32_t kEndianMark = 0x01020304u;
inline constexpr std::uint32_t kEndianMarkSwapped = 0x04030201u;
inline constexpr std::uint64_t kChunkAlignment = 64;
inline constexpr std::size_t kHeaderHashedBytes = 56;

constexpr std::uint64_t align_chunk(std::uint64_t offset) {
    return (offset + kChunkAlignment - 1) / kChunkAlignment * kChunkAlignment;
}

}  // namespace slim
