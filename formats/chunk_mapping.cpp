#include "formats/chunk_mapping.h"

#include <cerrno>

#include <sys/mman.h>
#include <unistd.h>

namespace slim {

ChunkMapping::~ChunkMapping() {
    if (pages_) ::munmap(pages_, n_bytes_);
}

int ChunkMapping::map(int file, std::uint64_t offset, std::uint64_t end, bool by_pages) {
    static const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    begin_ = offset / page * page;
    n_bytes_ = end - begin_;
    void* mapped =
        ::mmap(nullptr, n_bytes_, PROT_READ, MAP_SHARED, file, static_cast<off_t>(begin_));
    if (mapped == MAP_FAILED) return errno;
    pages_ = static_cast<unsigned char*>(mapped);
    // Without it the system reads up to megabytes around each page.
    if (by_pages) ::madvise(pages_, n_bytes_, MADV_RANDOM);
    return 0;
}

void ChunkMapping::read_ahead() const {
    // Asked for as it stands: without MADV_RANDOM the system would read megabytes beyond its end.
    ::madvise(pages_, n_bytes_, MADV_WILLNEED);
}

}  // namespace slim
