// What a log line can go through, looked at first: the C library's streams, wherever they lead (std::cout and
// the logging library end here too), and bare writes to stdout and stderr. A bell is rung by a write to a
// descriptor of its own.
#include <sys/uio.h>
#include <unistd.h>

#include <cstdarg>
#include <cstdio>

#include "tests/hot_path/hot_threads.hpp"
#include "tests/hot_path/next_function.hpp"

using fanlight::test::look_at;
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
  if (standard(descriptor)) look_at("write", __builtin_return_address(0));
  return next_write(descriptor, bytes, count);
}

ssize_t writev(int descriptor, const iovec* parts, int count) {
  if (standard(descriptor)) look_at("writev", __builtin_return_address(0));
  return next_writev(descriptor, parts, count);
}

std::size_t fwrite(const void* items, std::size_t bytes, std::size_t count, FILE* stream) {
  look_at("fwrite", __builtin_return_address(0));
  return next_fwrite(items, bytes, count, stream);
}

int fputs(const char* text, FILE* stream) {
  look_at("fputs", __builtin_return_address(0));
  return next_fputs(text, stream);
}

int puts(const char* text) {
  look_at("puts", __builtin_return_address(0));
  return next_puts(text);
}

int fputc(int character, FILE* stream) {
  look_at("fputc", __builtin_return_address(0));
  return next_fputc(character, stream);
}

int putc(int character, FILE* stream) {
  look_at("putc", __builtin_return_address(0));
  return next_putc(character, stream);
}

int putchar(int character) {
  look_at("putchar", __builtin_return_address(0));
  return next_putchar(character);
}

int vfprintf(FILE* stream, const char* format, va_list values) {
  look_at("vfprintf", __builtin_return_address(0));
  return next_vfprintf(stream, format, values);
}

int fprintf(FILE* stream, const char* format, ...) {
  look_at("fprintf", __builtin_return_address(0));
  va_list values;
  va_start(values, format);
  const int written = next_vfprintf(stream, format, values);
  va_end(values);
  return written;
}

int printf(const char* format, ...) {
  look_at("printf", __builtin_return_address(0));
  va_list values;
  va_start(values, format);
  const int written = next_vfprintf(stdout, format, values);
  va_end(values);
  return written;
}

}  // extern "C"
