// SPDX-License-Identifier: Apache-2.0
// Interposes the functions that can output a log line: the streams of the C library, whatever their target
// (std::cout and the logging library use them), and write() to stdout and stderr. Other descriptors are
// permitted: a Doorbell is rung by a write.
#include <sys/uio.h>
#include <unistd.h>

#include <cstdarg>
#include <cstdio>

#include "tests/hot_path/hot_threads.hpp"
#include "tests/hot_path/next_function.hpp"

using fanlight::test::check_call;
using fanlight::test::NextFunction;

namespace {

constinit NextFunction<ssize_t(int, const void*, std::size_t)> next_write("write");
constinit NextFunction<ssize_t(int, const iovec*, int)> next_writev("writev");
constinit NextFunction<std::size_t(const void*, std::size_t, std::size_t, FILE*)> next_fwrite("fwrite");
constinit NextFunction<int(const char*, FILE*)> next_fputs("fputs");
constinit NextFunction<int(const char*)> next_puts("puts");
constinit NextFunction<int(int, FILE*)> next_fputc("fputc");
constinit NextFunction<int(int, FILE*)> next_putc("putc");
constinit NextFunction<int(int)> next_putchar("putchar");
constinit NextFunction<int(FILE*, const char*, va_list)> next_vfprintf("vfprintf");

bool standard(int descriptor) {
  return descriptor == STDOUT_FILENO || descriptor == STDERR_FILENO;
}

}  // namespace

extern "C" {

ssize_t write(int descriptor, const void* bytes, std::size_t count) {
  if (standard(descriptor)) check_call("write", __builtin_return_address(0));
  return next_write(descriptor, bytes, count);
}

ssize_t writev(int descriptor, const iovec* parts, int count) {
  if (standard(descriptor)) check_call("writev", __builtin_return_address(0));
  return next_writev(descriptor, parts, count);
}

std::size_t fwrite(const void* items, std::size_t bytes, std::size_t count, FILE* stream) {
  check_call("fwrite", __builtin_return_address(0));
  return next_fwrite(items, bytes, count, stream);
}

int fputs(const char* text, FILE* stream) {
  check_call("fputs", __builtin_return_address(0));
  return next_fputs(text, stream);
}

int puts(const char* text) {
  check_call("puts", __builtin_return_address(0));
  return next_puts(text);
}

int fputc(int character, FILE* stream) {
  check_call("fputc", __builtin_return_address(0));
  return next_fputc(character, stream);
}

int putc(int character, FILE* stream) {
  check_call("putc", __builtin_return_address(0));
  return next_putc(character, stream);
}

int putchar(int character) {
  check_call("putchar", __builtin_return_address(0));
  return next_putchar(character);
}

int vfprintf(FILE* stream, const char* format, va_list values) {
  check_call("vfprintf", __builtin_return_address(0));
  return next_vfprintf(stream, format, values);
}

int fprintf(FILE* stream, const char* format, ...) {
  check_call("fprintf", __builtin_return_address(0));
  va_list values;
  va_start(values, format);
  const int written = next_vfprintf(stream, format, values);
  va_end(values);
  return written;
}

int printf(const char* format, ...) {
  check_call("printf", __builtin_return_address(0));
  va_list values;
  va_start(values, format);
  const int written = next_vfprintf(stdout, format, values);
  va_end(values);
  return written;
}

}  // extern "C"
