// SPDX-License-Identifier: Apache-2.0
// Asio, Beast and URL, compiled once. The other sources include their declarations only.
#include <boost/asio/impl/src.hpp>
#include <boost/asio/ssl/impl/src.hpp>
#include <boost/beast/src.hpp>
#if __has_include(<boost/url/src.hpp>)
#include <boost/url/src.hpp>
#endif
