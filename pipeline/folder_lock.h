#pragma once

#include <string>

namespace slim {

/// Keeps a work folder to one process at a time: an advisory lock on the folder itself, which ends
/// with the process however that ends (kill -9 too) and leaves no file behind. The folder is made
/// if it is missing, and may be removed while locked. On a file system without locks it does
/// nothing.
class FolderLock {
public:
    /// throws Error with exit code `temporary` (75) at once if another process holds it; IoError
    /// (2) if the folder cannot be made
    explicit FolderLock(const std::string& folder);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

private:
    int descriptor_ = -1;
};

}  // namespace slim
