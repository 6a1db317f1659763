import { createHash } from 'node:crypto';
import { readFileSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';
import { defineConfig } from 'vite';

// The server sends files as they were built, so they are compressed here, once. Fonts are compressed already.
function compressed() {
  let directory;
  return {
    name: 'compressed',
    apply: 'build',
    configResolved: (config) => void (directory = config.build.outDir),
    closeBundle() {
      for (const name of ['index.html', 'page.js', 'page.css']) {
        const file = join(directory, name);
        writeFileSync(`${file}.gz`, gzipSync(readFileSync(file), { level: 9 }));
        rmSync(file);
      }
    },
  };
}

/** The typeface comes with the first text, or all of it would be drawn twice. */
const typeface = {
  name: 'typeface',
  apply: 'build',
  transformIndexHtml: () => [{ tag: 'link', attrs: { rel: 'preload', href: '/page.woff2', as: 'font', type: 'font/woff2', crossorigin: '' }, injectTo: 'head' }],
};

/** The inline script by its hash: no other may run. The server's header says the rest. */
const ownScripts = {
  name: 'own-scripts',
  apply: 'build',
  transformIndexHtml: {
    order: 'post',
    handler(html) {
      const hashes = [...html.matchAll(/<script>([^]*?)<\/script>/g)].map(([, script]) => `'sha256-${createHash('sha256').update(script).digest('base64')}'`);
      const content = `script-src 'self' ${hashes.join(' ')}`;
      return [{ tag: 'meta', attrs: { 'http-equiv': 'Content-Security-Policy', content }, injectTo: 'head-prepend' }];
    },
  },
};

// Names without hashes: the server's build has to know them before the page is built.
export default defineConfig({
  base: '/',
  plugins: [typeface, ownScripts, compressed()],
  esbuild: { jsx: 'automatic', jsxImportSource: 'preact' },
  build: {
    target: 'es2021',
    assetsInlineLimit: 0,
    modulePreload: false,
    chunkSizeWarningLimit: 1500,
    emptyOutDir: true,
    reportCompressedSize: false,
    rollupOptions: {
      output: {
        inlineDynamicImports: true,
        entryFileNames: 'page.js',
        assetFileNames: (asset) => (asset.names[0]?.endsWith('.woff2') ? 'page.woff2' : 'page[extname]'),
      },
    },
  },
  server: { proxy: { '/api': { target: 'http://127.0.0.1:7448', ws: true }, '/healthz': 'http://127.0.0.1:7448' } },
});
