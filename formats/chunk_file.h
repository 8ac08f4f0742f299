#pragma once

#include "formats/atomic_file.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace slim {

/// Which of our binary files this is.
struct ChunkFileKind {
    std::string_view magic;  ///< 8 characters
    const char* what;        ///< for messages: "SLIM model"
    std::uint32_t version;   ///< written, and the newest that is read
};

/// Writes a file of named arrays, atomically. Throws as AtomicFile.
///
/// Small files: add() each array, commit(). Arrays too large for memory, of known counts: reserve()
/// them all, append() to them in any interleaving, commit(); each must then be full (a SLIM_CHECK).
class ChunkWriter {
public:
    ChunkWriter(const std::string& path, const ChunkFileKind& kind);
    ~ChunkWriter();
    ChunkWriter(ChunkWriter&&) noexcept;
    ChunkWriter& operator=(ChunkWriter&&) = delete;

    template <class T>
    void add(std::string_view name, std::span<const T> values) {
        static_assert(std::is_trivially_copyable_v<T>);
        append(reserve(name, sizeof(T), values.size()), values.data(), values.size());
    }
    /// Room for `count` elements; returns the chunk's number. Names have at most 23 characters.
    std::size_t reserve(std::string_view name, std::size_t element_size, std::uint64_t count);
    /// A chunk of as many elements as are appended before the next one is reserved.
    std::size_t open(std::string_view name, std::size_t element_size);
    void append(std::size_t chunk, const void* elements, std::size_t n);
    /// An older one than the kind's, which the file turned out to need no more than.
    void set_version(std::uint32_t version);
    void commit(Outlasts outlasts = Outlasts::power_cut);

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// A file of named arrays. Those that are asked for are mapped into memory; pages are read when
/// they are touched.
///
/// open() checks magic, version, byte order, length and the checksums of header and table; verify()
/// the checksum of a chunk. All throw FormatError naming the file, the place and what is wrong;
/// IoError if the file cannot be opened.
class ChunkFile {
public:
    /// by_pages: the system reads the pages that are touched and none around them; see
    /// read_ahead().
    static ChunkFile open(const std::string& path, const ChunkFileKind& kind,
                          bool by_pages = false);
    ~ChunkFile();
    ChunkFile(ChunkFile&&) noexcept;
    ChunkFile& operator=(ChunkFile&&) noexcept;

    const std::string& path() const;
    std::uint64_t file_size() const;
    std::uint32_t version() const;
    std::vector<std::string> names() const;
    bool has(std::string_view name) const;
    /// Byte offset of a chunk in the file, for messages.
    std::uint64_t offset(std::string_view name) const;
    /// Bytes of a chunk's array.
    std::uint64_t n_bytes(std::string_view name) const;
    /// XXH3-128 of header and table as 32 hex digits: the table holds the checksums of all chunks,
    /// so that files of different contents differ in it, and no chunk is read for it.
    std::string identity() const;
    /// Tells the system that all of a chunk will be read, and nothing around it.
    void read_ahead(std::string_view name) const;
    /// Reads a whole chunk against its checksum.
    void verify(std::string_view name) const;
    void verify_all() const;

    /// The array of that name; the view lives as long as this object (moving it does not matter).
    /// throws FormatError if there is none or its elements have another size
    template <class T>
    std::span<const T> array(std::string_view name) const {
        static_assert(std::is_trivially_copyable_v<T>);
        const auto [data, count] = raw(name, sizeof(T));
        return {static_cast<const T*>(data), count};
    }

    /// Copies bytes of a chunk, without mapping them and without a look at its checksum.
    /// Thread-safe. throws FormatError if they are beyond its end, IoError
    void read(std::string_view name, std::uint64_t first_byte, std::span<unsigned char> out) const;

    /// Calls body(first, piece) for an array in pieces from front to back, checks its checksum on
    /// the way and leaves no page of it mapped: for files larger than memory. body sees values
    /// before they are verified; the end of the call tells.
    /// throws as array() and verify()
    template <class T, class Body>
    void for_pieces(std::string_view name, Body&& body) const {
        const std::span<const T> values = array<T>(name);
        each_piece(name, sizeof(T), [&](std::size_t first, std::size_t n) {
            body(first, values.subspan(first, n));
        });
    }

private:
    struct State;
    struct Raw {
        const void* data;
        std::size_t count;
    };
    explicit ChunkFile(std::unique_ptr<State> state);
    Raw raw(std::string_view name, std::size_t element_size) const;
    void each_piece(std::string_view name, std::size_t element_size,
                    const std::function<void(std::size_t first, std::size_t n)>& body) const;

    std::unique_ptr<State> state_;
};

}  // namespace slim
