#pragma once

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace slim {

/// Leaves elements of trivial types undefined where std::allocator would write zeros.
template <class T>
struct UnfilledAllocator : std::allocator<T> {
    template <class U>
    struct rebind {
        using other = UnfilledAllocator<U>;
    };
    template <class U>
    void construct(U* p) {
        ::new (static_cast<void*>(p)) U;
    }
    template <class U, class... Args>
    void construct(U* p, Args&&... args) {
        std::construct_at(p, std::forward<Args>(args)...);
    }
};

/// A vector for large arrays that threads fill block by block: the first to touch a page pays for
/// it, and that is then not one thread for all.
template <class T>
using UnfilledVector = std::vector<T, UnfilledAllocator<T>>;

}  // namespace slim
