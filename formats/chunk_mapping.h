#pragma once

#include <cstddef>
#include <cstdint>

namespace slim {

/// A stretch of a file, its pages mapped into memory for reading until this object ends.
class ChunkMapping {
public:
    ChunkMapping() = default;
    ChunkMapping(const ChunkMapping&) = delete;
    ChunkMapping& operator=(const ChunkMapping&) = delete;
    ~ChunkMapping();

    bool is_there() const { return pages_ != nullptr; }
    /// The bytes from `offset` to `end`, at least one. Returns an errno, 0 if it went well.
    /// by_pages: the system reads the pages that are touched and none around them
    int map(int file, std::uint64_t offset, std::uint64_t end, bool by_pages);
    /// The byte at this offset of the file.
    const unsigned char* at(std::uint64_t offset) const { return pages_ + (offset - begin_); }
    /// Tells the system that all of it will be read, and nothing around it.
    void read_ahead() const;

private:
    unsigned char* pages_ = nullptr;
    std::uint64_t begin_ = 0;
    std::size_t n_bytes_ = 0;
};

}  // namespace slim
