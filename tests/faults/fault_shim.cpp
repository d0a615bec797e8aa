// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// Preloaded into a program (LD_PRELOAD), it makes one of its calls for files go wrong. Only calls for files
// below the folder EVERMAP_FAULT_ROOT count. EVERMAP_FAULT is
//   count:FILE   nothing goes wrong; their number is written into FILE
//   kill:N       before the N-th, the process kills itself
//   NAME:N       the N-th fails with that error, such as ENOSPC; NAME:N+ it and all later ones of its kind
//   short:N      the N-th, if it writes, writes half
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

namespace {

enum class Kind { kOpen, kWrite, kSync, kRename, kTruncate, kUnlink, kClose };

struct Plan {
  std::string root;
  std::string what;
  std::string file;
  long at = -1;
  bool for_ever = false;
  int error = 0;

  Plan() {
    const char* folder = std::getenv("EVERMAP_FAULT_ROOT");
    const char* fault = std::getenv("EVERMAP_FAULT");
    if (folder == nullptr || fault == nullptr) return;
    root = folder;
    const std::string text = fault;
    const std::size_t colon = text.find(':');
    what = text.substr(0, colon);
    const std::string rest = text.substr(colon + 1);
    if (what == "count") {
      file = rest;
    } else {
      at = std::atol(rest.c_str());
      for_ever = rest.back() == '+';
    }
    for (const auto& [name, number] : {std::pair{"ENOSPC", ENOSPC},
                                       {"EIO", EIO},
                                       {"EDQUOT", EDQUOT},
                                       {"EINTR", EINTR},
                                       {"EMFILE", EMFILE},
                                       {"EACCES", EACCES}}) {
      if (what == name) error = number;
    }
  }
};

/// Never destroyed: files are closed to the very end.
const Plan& plan() {
  static const Plan* const kPlan = new Plan;
  return *kPlan;
}

std::atomic<long> g_calls{0};
std::atomic<int> g_failed_kind{-1};

bool is_below_root(const char* path) {
  const std::string& root = plan().root;
  return !root.empty() && path != nullptr && std::strncmp(path, root.c_str(), root.size()) == 0;
}

std::string path_of(int descriptor) {
  char link[64];
  char path[4096];
  std::snprintf(link, sizeof(link), "/proc/self/fd/%d", descriptor);
  const ssize_t size = ::readlink(link, path, sizeof(path));
  return size > 0 ? std::string(path, static_cast<std::size_t>(size)) : std::string();
}

bool is_below_root(int descriptor) {
  return !plan().root.empty() && is_below_root(path_of(descriptor).c_str());
}

/// SQLite takes an interrupted fsync for a failure, which no file system on a disk has.
bool may_sync_fail(int descriptor) {
  return plan().error != EINTR || path_of(descriptor).find(".history") == std::string::npos;
}

enum class Fate { kPass, kFail, kHalf };

Fate fate_of(Kind kind) {
  const long call = ++g_calls;
  const Plan& now = plan();
  const bool is_hit = call == now.at || (now.for_ever && g_failed_kind == static_cast<int>(kind));
  if (!is_hit) return Fate::kPass;
  if (now.what == "kill") ::kill(::getpid(), SIGKILL);
  if (now.what == "short") return kind == Kind::kWrite ? Fate::kHalf : Fate::kPass;
  // What cannot happen to a call does not.
  const bool is_space = now.error == ENOSPC || now.error == EDQUOT;
  if (is_space && (kind == Kind::kUnlink || kind == Kind::kClose)) return Fate::kPass;
  if (now.error == EMFILE && kind != Kind::kOpen) return Fate::kPass;
  if (now.error == EINTR && (kind == Kind::kRename || kind == Kind::kUnlink)) return Fate::kPass;
  g_failed_kind = static_cast<int>(kind);
  return Fate::kFail;
}

int fail() {
  errno = plan().error;
  return -1;
}

struct Reporter {
  ~Reporter() {
    if (plan().what != "count") return;
    const std::string text = std::to_string(g_calls.load()) + "\n";
    const long file =
        ::syscall(SYS_openat, AT_FDCWD, plan().file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    ::syscall(SYS_write, file, text.data(), text.size());
    ::syscall(SYS_close, file);
  }
} g_reporter;

int open_at(int folder, const char* path, int flags, mode_t mode) {
  if (is_below_root(path) && fate_of(Kind::kOpen) != Fate::kPass) return fail();
  return static_cast<int>(::syscall(SYS_openat, folder, path, flags, mode));
}

/// How much of a write is done; 0: it fails.
std::size_t granted(int descriptor, std::size_t size) {
  if (!is_below_root(descriptor)) return size;
  const Fate fate = fate_of(Kind::kWrite);
  if (fate == Fate::kFail) return 0;
  return fate == Fate::kHalf && size > 1 ? size / 2 : size;
}

bool sync_fails(int descriptor) {
  return is_below_root(descriptor) && may_sync_fail(descriptor) && fate_of(Kind::kSync) != Fate::kPass;
}

mode_t mode_in(int flags, va_list arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? static_cast<mode_t>(va_arg(arguments, int)) : 0;
}

}  // namespace

extern "C" {

#define EVERMAP_OPEN(NAME)                         \
  int NAME(const char* path, int flags, ...) {     \
    va_list arguments;                             \
    va_start(arguments, flags);                    \
    const mode_t mode = mode_in(flags, arguments); \
    va_end(arguments);                             \
    return open_at(AT_FDCWD, path, flags, mode);   \
  }
EVERMAP_OPEN(open)
EVERMAP_OPEN(open64)
#define EVERMAP_OPENAT(NAME)                               \
  int NAME(int folder, const char* path, int flags, ...) { \
    va_list arguments;                                     \
    va_start(arguments, flags);                            \
    const mode_t mode = mode_in(flags, arguments);         \
    va_end(arguments);                                     \
    return open_at(folder, path, flags, mode);             \
  }
EVERMAP_OPENAT(openat)
EVERMAP_OPENAT(openat64)

ssize_t write(int descriptor, const void* data, size_t size) {
  const size_t some = granted(descriptor, size);
  if (some == 0 && size > 0) return fail();
  return ::syscall(SYS_write, descriptor, data, some);
}
ssize_t pwrite64(int descriptor, const void* data, size_t size, off64_t offset) {
  const size_t some = granted(descriptor, size);
  if (some == 0 && size > 0) return fail();
  return ::syscall(SYS_pwrite64, descriptor, data, some, offset);
}
ssize_t pwrite(int descriptor, const void* data, size_t size, off_t offset) {
  return pwrite64(descriptor, data, size, offset);
}
int fsync(int descriptor) {
  if (sync_fails(descriptor)) return fail();
  return static_cast<int>(::syscall(SYS_fsync, descriptor));
}
int fdatasync(int descriptor) {
  if (sync_fails(descriptor)) return fail();
  return static_cast<int>(::syscall(SYS_fdatasync, descriptor));
}
int rename(const char* from, const char* to) noexcept {
  if (is_below_root(to) && fate_of(Kind::kRename) != Fate::kPass) return fail();
  return static_cast<int>(::syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}
int ftruncate64(int descriptor, off64_t size) noexcept {
  if (is_below_root(descriptor) && fate_of(Kind::kTruncate) != Fate::kPass) return fail();
  return static_cast<int>(::syscall(SYS_ftruncate, descriptor, size));
}
int ftruncate(int descriptor, off_t size) noexcept { return ftruncate64(descriptor, size); }
int unlink(const char* path) noexcept {
  if (is_below_root(path) && fate_of(Kind::kUnlink) != Fate::kPass) return fail();
  return static_cast<int>(::syscall(SYS_unlinkat, AT_FDCWD, path, 0));
}
int close(int descriptor) {
  const bool counts = is_below_root(descriptor);
  const int result = static_cast<int>(::syscall(SYS_close, descriptor));
  if (counts && fate_of(Kind::kClose) != Fate::kPass) return fail();
  return result;
}

}  // extern "C"
