#include "formats/chunk_file.h"

#include "formats/chunk_layout.h"
#include "formats/chunk_mapping.h"
#include "formats/file_descriptor.h"
#include "formats/message.h"
#include "slim/base/error.h"

#define XXH_STATIC_LINKING_ONLY  // XXH3_state_t on the stack
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <mutex>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace slim {

struct ChunkFile::State {
    std::string path;
    FileDescriptor file;
    const char* what = "";
    bool by_pages = false;
    std::uint64_t size = 0;
    ChunkFileHeader header{};
    std::vector<ChunkEntry> table;
    std::mutex mapping;
    std::unique_ptr<ChunkMapping[]> mapped;  // of each chunk, once it is asked for

    [[noreturn]] void fail(std::uint64_t offset, const std::string& text) const {
        throw FormatError(message(path, ": byte ", offset, ": ", text));
    }
    [[noreturn]] void fail_checksum(const ChunkEntry& e) const;
    void open();
    void read(std::uint64_t offset, void* out, std::size_t n) const;
    void read_header(const ChunkFileKind& kind);
    void read_table();
    void check_entry(const ChunkEntry& entry) const;
    void check_gaps() const;
    const ChunkEntry* find(std::string_view name) const;
    const ChunkEntry& entry(std::string_view name) const;
    const ChunkMapping& map(const ChunkEntry& e);
    const unsigned char* bytes(const ChunkEntry& e);
};

namespace {

std::string name_of(const ChunkEntry& entry) {
    return {entry.name, strnlen(entry.name, sizeof(entry.name))};
}

std::string quoted(const char* bytes, std::size_t n) {
    std::string text;
    for (std::size_t i = 0; i < n; ++i)
        text += bytes[i] >= 0x20 && bytes[i] < 0x7f ? bytes[i] : '?';
    return '\'' + text + '\'';
}

}  // namespace

void ChunkFile::State::fail_checksum(const ChunkEntry& e) const {
    fail(e.offset, message("damaged: chunk ", name_of(e), " (", e.count * e.element_size,
                           " bytes) does not match its checksum"));
}

void ChunkFile::State::open() {
    file.fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status {};
    if (file.fd < 0 || ::fstat(file.fd, &status) != 0)
        throw IoError(
            {.file = path, .problem = message("cannot be opened: ", std::strerror(errno))});
    if (!S_ISREG(status.st_mode))
        throw IoError({.file = path, .problem = "is not a regular file"});
    size = static_cast<std::uint64_t>(status.st_size);
    if (size == 0) fail(0, message("the file is empty; expected a ", what));
    if (by_pages) ::posix_fadvise(file.fd, 0, 0, POSIX_FADV_RANDOM);
}

void ChunkFile::State::read(std::uint64_t offset, void* out, std::size_t n) const {
    auto* to = static_cast<unsigned char*>(out);
    while (n > 0) {
        const ssize_t got = ::pread(file.fd, to, n, static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0)
            throw IoError(
                message(path, ": byte ", offset, ": cannot be read: ", std::strerror(errno)));
        if (got == 0) fail(offset, "cut off while it was read");
        to += got, offset += static_cast<std::uint64_t>(got);
        n -= static_cast<std::size_t>(got);
    }
}

void ChunkFile::State::read_header(const ChunkFileKind& kind) {
    read(0, &header, std::min<std::size_t>(size, sizeof(header)));
    const std::size_t n_magic = std::min<std::size_t>(size, sizeof(header.magic));
    if (std::memcmp(header.magic, kind.magic.data(), n_magic) != 0)
        fail(0, message("this is not a ", what, ": expected '", kind.magic, "', found ",
                        quoted(header.magic, n_magic)));
    if (size < sizeof(header))
        fail(size, message("cut off: a ", what, " has at least ", sizeof(header), " bytes, found ",
                           size));
    if (header.endian_mark == kEndianMarkSwapped) fail(12, "written in the other byte order");
    if (header.endian_mark != kEndianMark) fail(12, "damaged: wrong byte order mark");
    // A newer version may have another header, so this comes before its checksum.
    if (header.version > kind.version)
        fail(8, message("written by a newer slim: ", what, " version ", header.version,
                        ", this one reads up to ", kind.version));
    if (header.version == 0) fail(8, "damaged: version 0");
    if (header.header_checksum != XXH3_64bits(&header, kHeaderHashedBytes))
        fail(0, "damaged: the header does not match its checksum");
    if (header.file_size != size)
        fail(std::min(size, header.file_size),
             message(size < header.file_size ? "cut off" : "too long", ": expected ",
                     header.file_size, " bytes, found ", size));
}

void ChunkFile::State::read_table() {
    const std::uint64_t table_size = header.n_chunks * std::uint64_t{sizeof(ChunkEntry)};
    if (header.table_offset > size || table_size != size - header.table_offset)
        fail(24, "damaged: the table of chunks is out of bounds");
    table.resize(header.n_chunks);
    read(header.table_offset, table.data(), table_size);
    if (header.table_checksum != XXH3_64bits(table.data(), table_size))
        fail(header.table_offset, "damaged: the table of chunks does not match its checksum");
    mapped = std::make_unique<ChunkMapping[]>(table.size());
    for (const ChunkEntry& e : table) check_entry(e);
}

void ChunkFile::State::check_entry(const ChunkEntry& e) const {
    const bool fits = e.element_size > 0 && e.offset % kChunkAlignment == 0 &&
                      e.offset >= sizeof(ChunkFileHeader) && e.offset <= header.table_offset &&
                      e.count <= (header.table_offset - e.offset) / e.element_size;
    if (!fits)
        fail(header.table_offset, message("damaged: chunk ", name_of(e), " is out of bounds"));
}

/// No checksum covers the bytes between chunks, so they must be zero: no flipped bit goes unseen.
void ChunkFile::State::check_gaps() const {
    std::uint64_t at = sizeof(ChunkFileHeader);
    const auto zeros_until = [&](std::uint64_t end) {
        char gap[kChunkAlignment] = {};
        if (at < end) read(at, gap, std::min<std::uint64_t>(end - at, sizeof gap));
        for (std::size_t i = 0; at < end && i < sizeof gap; ++at, ++i)
            if (gap[i] != 0) fail(at, "damaged: expected a zero between chunks");
    };
    for (const ChunkEntry& e : table) {
        if (e.offset < at || e.offset - at >= kChunkAlignment)
            fail(header.table_offset, message("damaged: chunk ", name_of(e), " is out of place"));
        zeros_until(e.offset);
        at = e.offset + e.count * e.element_size;
    }
    zeros_until(header.table_offset);
}

const ChunkEntry* ChunkFile::State::find(std::string_view name) const {
    for (const ChunkEntry& e : table)
        if (name_of(e) == name) return &e;
    return nullptr;
}

const ChunkEntry& ChunkFile::State::entry(std::string_view name) const {
    const ChunkEntry* e = find(name);
    if (!e) fail(header.table_offset, message("this ", what, " has no chunk ", name));
    return *e;
}

/// Mapped when it is first asked for: what is read() alone, as the points of slices are, takes no
/// room among the addresses, which a limit on these (`ulimit -v`) counts.
const ChunkMapping& ChunkFile::State::map(const ChunkEntry& e) {
    const std::lock_guard lock(mapping);
    ChunkMapping& chunk = mapped[static_cast<std::size_t>(&e - table.data())];
    if (chunk.is_there()) return chunk;
    const std::uint64_t end = e.offset + e.count * e.element_size;
    if (const int error = chunk.map(file.fd, e.offset, end, by_pages))
        throw ResourceError(message(path, ": cannot be mapped: ", std::strerror(error)));
    return chunk;
}

const unsigned char* ChunkFile::State::bytes(const ChunkEntry& e) {
    alignas(kChunkAlignment) static const unsigned char none[1] = {};
    return e.count > 0 ? map(e).at(e.offset) : none;
}

ChunkFile::ChunkFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
ChunkFile::~ChunkFile() = default;
ChunkFile::ChunkFile(ChunkFile&&) noexcept = default;
ChunkFile& ChunkFile::operator=(ChunkFile&&) noexcept = default;

ChunkFile ChunkFile::open(const std::string& path, const ChunkFileKind& kind, bool by_pages) {
    auto state = std::make_unique<State>();
    state->path = path;
    state->what = kind.what;
    state->by_pages = by_pages;
    state->open();
    state->read_header(kind);
    state->read_table();
    state->check_gaps();
    return ChunkFile(std::move(state));
}

const std::string& ChunkFile::path() const { return state_->path; }
std::uint64_t ChunkFile::file_size() const { return state_->size; }
std::uint32_t ChunkFile::version() const { return state_->header.version; }
bool ChunkFile::has(std::string_view name) const { return state_->find(name) != nullptr; }
std::uint64_t ChunkFile::offset(std::string_view name) const { return state_->entry(name).offset; }
std::uint64_t ChunkFile::n_bytes(std::string_view name) const {
    const ChunkEntry& e = state_->entry(name);
    return e.count * e.element_size;
}

std::vector<std::string> ChunkFile::names() const {
    std::vector<std::string> names;
    for (const ChunkEntry& e : state_->table) names.push_back(name_of(e));
    return names;
}

void ChunkFile::verify(std::string_view name) const {
    const ChunkEntry& e = state_->entry(name);
    if (e.checksum != XXH3_64bits(state_->bytes(e), e.count * e.element_size))
        state_->fail_checksum(e);
}

void ChunkFile::each_piece(std::string_view name, std::size_t element_size,
                           const std::function<void(std::size_t, std::size_t)>& body) const {
    constexpr std::size_t kPieceBytes = std::size_t{1} << 20;
    const ChunkEntry& e = state_->entry(name);
    const unsigned char* const data = state_->bytes(e);
    const auto let_go = [](const unsigned char* from, const unsigned char* to) {
        // Whole pages only; neighbours of the ends are read again if need be.
        static const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
        const std::uintptr_t begin = reinterpret_cast<std::uintptr_t>(from) / page * page;
        const std::uintptr_t end = reinterpret_cast<std::uintptr_t>(to);
        ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_DONTNEED);
    };
    XXH3_state_t hash;
    XXH3_64bits_reset(&hash);
    const std::size_t step = std::max<std::size_t>(1, kPieceBytes / element_size);
    // The system maps pages around the one that is asked for, also of pieces that were let go: a
    // quarter of a file of 70 MB stayed.
    const std::size_t behind = 2 * step;
    for (std::size_t first = 0; first < e.count; first += step) {
        const std::size_t n = std::min<std::size_t>(step, e.count - first);
        const unsigned char* const piece = data + first * element_size;
        XXH3_64bits_update(&hash, piece, n * element_size);
        body(first, n);
        let_go(first > behind ? piece - behind * element_size : data, piece + n * element_size);
    }
    if (e.count > 0) let_go(data, data + e.count * e.element_size);
    if (e.checksum != XXH3_64bits_digest(&hash)) state_->fail_checksum(e);
}

void ChunkFile::read(std::string_view name, std::uint64_t first_byte,
                     std::span<unsigned char> out) const {
    const ChunkEntry& e = state_->entry(name);
    const std::uint64_t n_bytes = e.count * e.element_size;
    if (first_byte > n_bytes || out.size() > n_bytes - first_byte)
        state_->fail(e.offset,
                     message("chunk ", name, ": expected ", out.size(), " bytes from byte ",
                             first_byte, " on, found ", n_bytes, " in all"));
    state_->read(e.offset + first_byte, out.data(), out.size());
}

std::string ChunkFile::identity() const {
    const auto bytes_of = [](const auto* p) { return reinterpret_cast<const unsigned char*>(p); };
    const std::vector<ChunkEntry>& table = state_->table;
    std::vector<unsigned char> bytes(bytes_of(&state_->header), bytes_of(&state_->header + 1));
    bytes.insert(bytes.end(), bytes_of(table.data()), bytes_of(table.data() + table.size()));
    const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
    char text[33];
    std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                  static_cast<unsigned long long>(hash.low64));
    return text;
}

void ChunkFile::read_ahead(std::string_view name) const {
    const ChunkEntry& e = state_->entry(name);
    if (e.count > 0) state_->map(e).read_ahead();
}

void ChunkFile::verify_all() const {
    for (const ChunkEntry& e : state_->table) verify(name_of(e));
}

ChunkFile::Raw ChunkFile::raw(std::string_view name, std::size_t element_size) const {
    const ChunkEntry& e = state_->entry(name);
    if (e.element_size != element_size)
        state_->fail(state_->header.table_offset,
                     message("chunk ", name, ": expected elements of ", element_size,
                             " bytes, found ", e.element_size));
    return {state_->bytes(e), static_cast<std::size_t>(e.count)};
}

}  // namespace slim
