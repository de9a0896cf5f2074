// SPDX-License-Identifier: Apache-2.0
// build.mjs makes a text of the element's style.
declare module "*.css" {
  const text: string;
  export default text;
}
