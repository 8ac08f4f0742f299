#include "slim/base/large_blocks.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <new>

#include <sys/mman.h>

namespace slim {
namespace {

constexpr std::size_t kLarge = std::size_t{1} << 20;
constexpr std::size_t kPage = 4096;
// Blocks in use are not touched to their ends, as kept ones are: only so much of the most that was in use is held again.
constexpr std::size_t kPartsTouched = 4, kParts = 5;
constexpr std::size_t kMostBlocks = 2048;  // of each list; beyond them the heap serves

struct Block {
    std::uintptr_t begin;
    std::size_t size;
};

/// A few blocks, in no order; without allocations of its own, as it serves operator new.
class BlockList {
public:
    bool is_full() const { return n_ == blocks_.size(); }
    std::size_t n_bytes() const { return n_bytes_; }
    void add(Block block) {
        blocks_[n_++] = block;
        n_bytes_ += block.size;
    }
    Block take(std::size_t i) {
        const Block block = blocks_[i];
        blocks_[i] = blocks_[--n_];
        n_bytes_ -= block.size;
        return block;
    }
    /// Number of the block that begins there; size() if there is none.
    std::size_t find(std::uintptr_t begin) const {
        std::size_t i = 0;
        while (i < n_ && blocks_[i].begin != begin) ++i;
        return i;
    }
    /// The smallest of at least that size; size() if there is none.
    std::size_t best_fit(std::size_t size) const {
        std::size_t best = n_;
        for (std::size_t i = 0; i < n_; ++i)
            if (blocks_[i].size >= size && (best == n_ || blocks_[i].size < blocks_[best].size)) best = i;
        return best;
    }
    std::size_t size() const { return n_; }
    const Block& operator[](std::size_t i) const { return blocks_[i]; }

private:
    std::array<Block, kMostBlocks> blocks_{};
    std::size_t n_ = 0, n_bytes_ = 0;
};

void unmap(std::uintptr_t begin, std::size_t size) {
    if (size > 0) ::munmap(reinterpret_cast<void*>(begin), size);
}

class LargeBlocks {
public:
    /// nullptr if there is no memory or no more room in the lists
    void* allocate(std::size_t n_bytes) {
        const std::size_t size = (n_bytes + kPage - 1) / kPage * kPage;
        const std::lock_guard lock(mutex_);
        if (size < n_bytes || used_.is_full()) return nullptr;
        const std::size_t fit = kept_.best_fit(size);
        const std::uintptr_t begin = fit < kept_.size() ? front_of(kept_.take(fit), size) : map(size);
        if (begin == 0) return nullptr;
        used_.add({begin, size});
        most_used_ = std::max(most_used_, used_.n_bytes());
        return reinterpret_cast<void*>(begin);
    }
    /// False if it is none of these.
    bool free(void* p) {
        const auto begin = reinterpret_cast<std::uintptr_t>(p);
        const std::lock_guard lock(mutex_);
        const std::size_t i = used_.find(begin);
        if (i == used_.size()) return false;
        keep(used_.take(i));
        return true;
    }
    void release_all() {
        const std::lock_guard lock(mutex_);
        release(kept_.n_bytes());
    }
    LargeBlockUse use() {
        const std::lock_guard lock(mutex_);
        return {used_.n_bytes(), kept_.n_bytes(), most_used_};
    }

private:
    /// The front of a kept block; the rest is kept on if it is large.
    std::uintptr_t front_of(Block block, std::size_t size) {
        keep({block.begin + size, block.size - size});
        return block.begin;
    }
    /// Joined with what is kept before and behind it.
    void keep(Block block) {
        for (std::size_t i = 0; i < kept_.size();) {
            const Block other = kept_[i];
            if (other.begin + other.size != block.begin && block.begin + block.size != other.begin) {
                ++i;
                continue;
            }
            kept_.take(i);
            block = {std::min(block.begin, other.begin), block.size + other.size};
            i = 0;
        }
        if (block.size >= kLarge && !kept_.is_full())
            kept_.add(block);
        else
            unmap(block.begin, block.size);
    }
    /// New pages, in place of kept ones where there would be more than before.
    std::uintptr_t map(std::size_t size) {
        const std::size_t most = std::max(most_used_ / kParts * kPartsTouched, used_.n_bytes() + size);
        const std::size_t all = used_.n_bytes() + kept_.n_bytes() + size;
        if (all > most) release(all - most);
        const auto try_map = [&] {
            return ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        };
        void* mapped = try_map();
        if (mapped == MAP_FAILED && kept_.size() > 0) {
            release(kept_.n_bytes());
            mapped = try_map();
        }
        return mapped == MAP_FAILED ? 0 : reinterpret_cast<std::uintptr_t>(mapped);
    }
    /// At least so many bytes of what is kept, the ends of the last blocks; what is left of one is large.
    void release(std::size_t n_bytes) {
        while (n_bytes > 0 && kept_.size() > 0) {
            Block block = kept_.take(kept_.size() - 1);
            const std::size_t cut =
                block.size >= n_bytes + kLarge ? (n_bytes + kPage - 1) / kPage * kPage : block.size;
            unmap(block.begin + block.size - cut, cut);
            block.size -= cut;
            if (block.size > 0) kept_.add(block);
            n_bytes -= std::min(n_bytes, cut);
        }
    }

    std::mutex mutex_;
    BlockList used_, kept_;
    std::size_t most_used_ = 0;
};

constinit LargeBlocks blocks;

}  // namespace

void release_large_blocks() { blocks.release_all(); }
LargeBlockUse large_block_use() { return blocks.use(); }

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
namespace {

/// As operator new does: asks its handler for memory, or throws.
template <class Try>
void* obtain(const Try& attempt) {
    for (;;) {
        if (void* p = attempt()) return p;
        const std::new_handler handler = std::get_new_handler();
        if (!handler) throw std::bad_alloc();
        handler();
    }
}

void* obtain_memory(std::size_t n) {
    return obtain([n]() -> void* {
        void* p = n >= kLarge ? blocks.allocate(n) : nullptr;
        return p ? p : std::malloc(std::max<std::size_t>(n, 1));
    });
}

void* obtain_aligned(std::size_t n, std::size_t alignment) {
    return obtain([n, alignment]() -> void* {
        void* p = n >= kLarge && alignment <= kPage ? blocks.allocate(n) : nullptr;
        return p ? p : std::aligned_alloc(alignment, (std::max<std::size_t>(n, 1) + alignment - 1) / alignment * alignment);
    });
}

/// Large blocks begin with a page; so do few others.
void give_back(void* p) noexcept {
    const bool may_be_large = reinterpret_cast<std::uintptr_t>(p) % kPage == 0;
    if (p && !(may_be_large && blocks.free(p))) std::free(p);
}

}  // namespace
#endif

}  // namespace slim

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

// The other forms call these.
void* operator new(std::size_t n) { return slim::obtain_memory(n); }
void* operator new(std::size_t n, std::align_val_t alignment) {
    return slim::obtain_aligned(n, static_cast<std::size_t>(alignment));
}
void operator delete(void* p) noexcept { slim::give_back(p); }
void operator delete(void* p, std::size_t) noexcept { slim::give_back(p); }
void operator delete(void* p, std::align_val_t) noexcept { slim::give_back(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { slim::give_back(p); }

#endif
