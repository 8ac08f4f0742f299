#include "formats/atomic_file.h"
#include "formats/chunk_file.h"
#include "formats/chunk_layout.h"
#include "slim/base/check.h"

#include <xxhash.h>

#include <algorithm>
#include <cstring>

namespace slim {
namespace {

struct HashDeleter {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
};

struct OpenChunk {
    ChunkEntry entry{};
    std::uint64_t n_written = 0;
    bool is_open = false;
    std::unique_ptr<XXH3_state_t, HashDeleter> hash{XXH3_createState()};
};

}  // namespace

struct ChunkWriter::State {
    AtomicFile file;
    ChunkFileHeader header{};
    std::uint64_t end = sizeof(ChunkFileHeader);
    std::vector<OpenChunk> chunks;

    explicit State(const std::string& path) : file(path) {}
};

ChunkWriter::ChunkWriter(const std::string& path, const ChunkFileKind& kind)
    : state_(std::make_unique<State>(path)) {
    SLIM_CHECK(kind.magic.size(), ==, sizeof(ChunkFileHeader::magic));
    std::memcpy(state_->header.magic, kind.magic.data(), sizeof(ChunkFileHeader::magic));
    state_->header.version = kind.version;
    state_->header.endian_mark = kEndianMark;
}

ChunkWriter::~ChunkWriter() = default;
ChunkWriter::ChunkWriter(ChunkWriter&&) noexcept = default;

std::size_t ChunkWriter::reserve(std::string_view name, std::size_t element_size,
                                 std::uint64_t count) {
    SLIM_CHECK(name.size(), <, sizeof(ChunkEntry::name));
    SLIM_CHECK(element_size, >, 0u);
    if (!state_->chunks.empty()) state_->chunks.back().is_open = false;
    OpenChunk chunk;
    name.copy(chunk.entry.name, name.size());
    chunk.entry.element_size = static_cast<std::uint32_t>(element_size);
    chunk.entry.count = count;
    chunk.entry.offset = align_chunk(state_->end);
    state_->end = chunk.entry.offset + count * element_size;
    XXH3_64bits_reset(chunk.hash.get());
    state_->chunks.push_back(std::move(chunk));
    return state_->chunks.size() - 1;
}

std::size_t ChunkWriter::open(std::string_view name, std::size_t element_size) {
    const std::size_t chunk = reserve(name, element_size, 0);
    state_->chunks[chunk].is_open = true;
    return chunk;
}

void ChunkWriter::set_version(std::uint32_t version) { state_->header.version = version; }

void ChunkWriter::append(std::size_t chunk, const void* elements, std::size_t n) {
    OpenChunk& c = state_->chunks.at(chunk);
    if (c.is_open) {
        c.entry.count += n;
        state_->end = c.entry.offset + c.entry.count * c.entry.element_size;
    }
    SLIM_CHECK(c.n_written + n, <=, c.entry.count);
    if (n == 0) return;
    const std::size_t size = n * c.entry.element_size;
    XXH3_64bits_update(c.hash.get(), elements, size);
    state_->file.write_at(c.entry.offset + c.n_written * c.entry.element_size, elements, size);
    c.n_written += n;
}

void ChunkWriter::commit(Outlasts outlasts) {
    std::vector<ChunkEntry> table;
    for (OpenChunk& c : state_->chunks) {
        SLIM_CHECK(c.n_written, ==, c.entry.count);
        c.entry.checksum = XXH3_64bits_digest(c.hash.get());
        table.push_back(c.entry);
    }
    ChunkFileHeader& header = state_->header;
    const std::size_t table_size = table.size() * sizeof(ChunkEntry);
    header.table_offset = align_chunk(state_->end);
    header.file_size = header.table_offset + table_size;
    header.n_chunks = static_cast<std::uint32_t>(table.size());
    header.table_checksum = XXH3_64bits(table.data(), table_size);
    header.header_checksum = XXH3_64bits(&header, kHeaderHashedBytes);
    state_->file.write_at(header.table_offset, table.data(), table_size);
    state_->file.write_at(0, &header, sizeof(header));
    state_->file.commit(outlasts);
}

}  // namespace slim
