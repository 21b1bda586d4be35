import react from "@vitejs/plugin-react";
import { defineConfig } from "vite";

// The pages are built into the Python package, which serves them; `npm run dev` asks a service at its usual address.
export default defineConfig({
  plugins: [react()],
  build: {
    outDir: "../src/trueloop/pages",
    emptyOutDir: true,
    manifest: "manifest.json",
    license: { fileName: "licences.txt" },
    assetsInlineLimit: 0,
  },
  server: { proxy: { "/api": "http://127.0.0.1:8080", "/healthz": "http://127.0.0.1:8080" } },
});
