"""From a project file to the values that a loop works on."""
